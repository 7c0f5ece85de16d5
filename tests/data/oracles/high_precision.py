#!/usr/bin/python3
"""Evaluates a URDF at random states in 50 digits, straight from its text and from definitions alone:
Jacobians of centres of mass, M as their sum, C by the Koszul formula from differences of M at 1e-40.
Shares nothing with the library it judges. Writes the format of README.md; to make one anew:

    ./high_precision.py ../robots/offaxis.urdf --ee tool --states 5 > offaxis_hp.json

--check FILE.json evaluates the first states of a file again and compares (ctest does)."""
import argparse
import json
import pathlib
import random
import sys
import xml.etree.ElementTree
from decimal import Decimal, getcontext

getcontext().prec = 110
STEP = Decimal(10) ** -40  # central differences err by its square, and round at 1e-70
ZERO, ONE = Decimal(0), Decimal(1)


def sine_cosine(x):
    """By their series after halving; the angle is doubled back."""
    halvings = 0
    while abs(x) > Decimal("0.1"):
        x /= 2
        halvings += 1
    s, c, term, k = ZERO, ZERO, ONE, 0
    while abs(term) > Decimal(10) ** -112:
        if k % 2 == 0:
            c += term if k % 4 == 0 else -term
        else:
            s += term if k % 4 == 1 else -term
        k += 1
        term *= x / k
    for _ in range(halvings):
        s, c = 2 * s * c, c * c - s * s
    return s, c


def times(a, b):
    return [[sum((a[i][k] * b[k][j] for k in range(len(b))), ZERO) for j in range(len(b[0]))]
            for i in range(len(a))]


def apply(a, x):
    return [sum((row[k] * x[k] for k in range(3)), ZERO) for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), ZERO)


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def about(axis, angle):
    """Rodrigues' formula, axis of unit length."""
    s, c = sine_cosine(angle)
    x, y, z = axis
    v = 1 - c
    return [[c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [x * y * v + z * s, c + y * y * v, y * z * v - x * s],
            [x * z * v - y * s, y * z * v + x * s, c + z * z * v]]


IDENTITY = [[ONE if i == j else ZERO for j in range(3)] for i in range(3)]
AXES = IDENTITY


def triple(element, name, absent="0 0 0"):
    text = absent if element is None else element.get(name, absent)
    return [Decimal(word) for word in text.split()]


def origin(element):
    roll, pitch, yaw = triple(element.find("origin"), "rpy")
    turn = times(about(AXES[2], yaw), times(about(AXES[1], pitch), about(AXES[0], roll)))
    return turn, triple(element.find("origin"), "xyz")


class Robot:
    def __init__(self, file, floating):
        root = xml.etree.ElementTree.parse(file).getroot()
        self.name = root.get("name")
        self.floating = floating
        self.inertia = {}
        for link in root.findall("link"):
            inertial = link.find("inertial")
            if inertial is None:
                continue
            turn, com = origin(inertial)
            i = {k: Decimal(v) for k, v in inertial.find("inertia").attrib.items()}
            matrix = [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]],
                      [i["ixz"], i["iyz"], i["izz"]]]
            self.inertia[link.get("name")] = (Decimal(inertial.find("mass").get("value")), com,
                                              times(turn, times(matrix, transposed(turn))))
        joints = {joint.get("name"): joint for joint in root.findall("joint")}
        child = {joint.find("child").get("link") for joint in joints.values()}
        self.root = next(link.get("name") for link in root.findall("link")
                         if link.get("name") not in child)
        self.joints, self.dof_names = [], []
        open_links = [self.root]
        self.visit(joints, open_links[0])
        self.first = 6 if floating else 0
        self.nv = self.first + len(self.dof_names)

    def visit(self, joints, link):
        """Depth first, siblings by joint name."""
        for name in sorted(n for n, j in joints.items() if j.find("parent").get("link") == link):
            joint = joints[name]
            kind = joint.get("type")
            axis = triple(joint.find("axis"), "xyz", "1 0 0")
            length = dot(axis, axis).sqrt()
            dof = -1
            if kind != "fixed":
                dof = len(self.dof_names)
                self.dof_names.append((name, kind))
            self.joints.append((link, joint.find("child").get("link"), kind, origin(joint),
                                [x / length for x in axis], dof))
            self.visit(joints, self.joints[-1][1])

    def place(self, base, q):
        """Pose and path of every link, and for every degree of freedom its axis and a point of it."""
        turn, point = base
        pose = {self.root: (turn, point)}
        path = {self.root: []}
        moves = []
        if self.floating:
            for k in range(3):
                moves.append((True, [turn[i][k] for i in range(3)], point))
            for k in range(3):
                moves.append((False, [turn[i][k] for i in range(3)], point))
            path[self.root] = list(range(6))
        for parent, child, kind, (turn0, point0), axis, dof in self.joints:
            turn, point = pose[parent]
            point = plus(point, apply(turn, point0))
            turn = times(turn, turn0)
            path[child] = path[parent]
            if dof >= 0:
                along = apply(turn, axis)
                slides = kind == "prismatic"
                moves.append((slides, along, point))
                path[child] = path[parent] + [self.first + dof]
                if slides:
                    point = plus(point, [q[dof] * x for x in along])
                else:
                    turn = times(turn, about(axis, q[dof]))
            pose[child] = (turn, point)
        return pose, path, moves

    def moving_links(self, path):
        return [link for link in self.inertia if path[link] and self.inertia[link][0] >= 0]

    def columns(self, path, moves, link, point):
        """(linear, angular) velocity of a point of a link per degree of freedom, world axes."""
        for k in path[link]:
            slides, along, at = moves[k]
            yield k, ((along, [ZERO] * 3) if slides else (cross(along, minus(point, at)), along))

    def bodies(self, placed):
        pose, path, moves = placed
        for link in self.moving_links(path):
            mass, com, inertia = self.inertia[link]
            turn, point = pose[link]
            centre = plus(point, apply(turn, com))
            world = times(turn, times(inertia, transposed(turn)))
            yield mass, centre, world, list(self.columns(path, moves, link, centre))

    def metric(self, placed):
        m = [[ZERO] * self.nv for _ in range(self.nv)]
        for mass, _, inertia, columns in self.bodies(placed):
            momenta = [(k, [mass * x for x in v], apply(inertia, w)) for k, (v, w) in columns]
            for i, (v, w) in columns:
                for j, p, h in momenta:
                    if j <= i:
                        m[i][j] += dot(v, p) + dot(w, h)
        for i in range(self.nv):
            for j in range(i):
                m[j][i] = m[i][j]
        return m

    def bracket(self, i, j):
        """[e_i, e_j] of the left-invariant fields of SE(3), as {index: coefficient}."""
        if not self.floating or i > 5 or j > 5 or (i < 3 and j < 3):
            return {}
        e = cross(AXES[i % 3], AXES[j % 3])
        first = 3 if i > 2 and j > 2 else 0
        return {first + k: e[k] for k in range(3) if e[k] != 0}

    def connection(self, base, q, m):
        """G[k][i][j] = <nabla_k e_j, e_i> by the Koszul formula. M does not depend on the base."""
        n = self.nv
        slope = [[[ZERO] * n for _ in range(n)] for _ in range(n)]
        for k in range(len(q)):
            ahead, behind = list(q), list(q)
            ahead[k] += STEP
            behind[k] -= STEP
            a, b = self.metric(self.place(base, ahead)), self.metric(self.place(base, behind))
            slope[self.first + k] = [[(x - y) / (2 * STEP) for x, y in zip(r, s)]
                                     for r, s in zip(a, b)]

        def product(i, j, k):
            return sum((c * m[l][k] for l, c in self.bracket(i, j).items()), ZERO)

        return [[[(slope[k][i][j] + slope[j][i][k] - slope[i][j][k] + product(k, j, i)
                   - product(k, i, j) - product(j, i, k)) / 2
                  for j in range(n)] for i in range(n)] for k in range(n)], slope


def inverse(m):
    n = len(m)
    a = [row[:] + [ONE if i == j else ZERO for j in range(n)] for i, row in enumerate(m)]
    for k in range(n):
        pivot = a[k][k]  # positive definite: no exchange is needed
        a[k] = [x / pivot for x in a[k]]
        for i in range(n):
            if i != k and a[i][k] != 0:
                f = a[i][k]
                a[i] = [x - f * y for x, y in zip(a[i], a[k])]
    return [row[n:] for row in a]


def evaluate(robot, gravity, ee, q, v, a, symbols):
    q, v, a = ([Decimal(x) for x in each] for each in (q, v, a))
    base = (IDENTITY, [ZERO] * 3)
    joints = q
    if robot.floating:
        norm = dot(q[3:7], q[3:7]).sqrt()
        x, y, z, w = (c / norm for c in q[3:7])
        base = ([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]], q[:3])
        joints = q[7:]
    n = robot.nv
    placed = robot.place(base, joints)
    m = robot.metric(placed)
    gamma, slope = robot.connection(base, joints, m)
    c = [[sum((gamma[k][i][j] * v[k] for k in range(n)), ZERO) for j in range(n)] for i in range(n)]
    rate = [[sum((slope[k][i][j] * v[k] for k in range(n)), ZERO) for j in range(n)]
            for i in range(n)]
    g = [ZERO] * n
    potential, total = ZERO, ZERO
    moment, linear, angular = [ZERO] * 3, [ZERO] * 3, [ZERO] * 3
    for mass, centre, inertia, columns in robot.bodies(placed):
        velocity, turning = [ZERO] * 3, [ZERO] * 3
        for k, (lin, ang) in columns:
            g[k] -= mass * dot(lin, gravity)
            velocity = plus(velocity, [v[k] * x for x in lin])
            turning = plus(turning, [v[k] * x for x in ang])
        potential -= mass * dot(gravity, centre)
        total += mass
        moment = plus(moment, [mass * x for x in centre])
        linear = plus(linear, [mass * x for x in velocity])
        angular = plus(angular, plus(apply(inertia, turning),
                                     cross(centre, [mass * x for x in velocity])))
    mv = [dot(row, v) for row in m]
    cv = [dot(row, v) for row in c]
    pose, path, moves = placed
    jacobian = [[ZERO] * n for _ in range(6)]
    for k, (lin, ang) in robot.columns(path, moves, ee, pose[ee][1]):
        for i in range(3):
            jacobian[i][k], jacobian[3 + i][k] = lin[i], ang[i]
    state = {"q": q, "v": v, "a": a,
             "tau": [dot(row, a) + x + y for row, x, y in zip(m, cv, g)], "g": g, "Cv": cv, "M": m,
             "Minv": inverse(m), "C": c, "Mdot": rate, "kinetic_energy": dot(v, mv) / 2,
             "potential_energy": potential, "J_ee": jacobian, "ee_R": pose[ee][0],
             "ee_p": pose[ee][1]}
    if robot.floating:
        com = [x / total for x in moment]
        state.update({"com": com, "vcom": [x / total for x in linear], "hg_linear": linear,
                      "hg_angular": minus(angular, cross(com, linear))})
    if symbols:
        state["christoffel_first_kind"] = [[[gamma[k][i][j] for k in range(n)] for j in range(n)]
                                           for i in range(n)]
    return rounded(state)


def rounded(value):
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    return [rounded(v) for v in value] if isinstance(value, list) else float(value)


def header(robot, arguments, file):
    joints, first_q = [], 7 if robot.floating else 0
    if robot.floating:
        joints.append({"name": "root_joint", "type": "free", "idx_q": 0, "idx_v": 0, "nq": 7,
                       "nv": 6})
    for k, (name, kind) in enumerate(robot.dof_names):
        joints.append({"name": name, "type": kind, "idx_q": first_q + k, "idx_v": robot.first + k,
                       "nq": 1, "nv": 1})
    return {"robot": robot.name, "urdf": file, "source": "high_precision.py, 50 digits",
            "floating_base": robot.floating, "nq": first_q + len(robot.dof_names), "nv": robot.nv,
            "gravity": [0, 0, -9.81], "ee_frame": arguments.ee, "joints": joints}


def random_state(robot, rng):
    n = len(robot.dof_names)
    q = [rng.uniform(-0.2, 0.2) if kind == "prismatic" else rng.uniform(-3, 3)
         for _, kind in robot.dof_names]
    if robot.floating:
        quaternion = [rng.gauss(0, 1) for _ in range(4)]
        norm = sum(x * x for x in quaternion) ** 0.5
        q = [rng.uniform(-1, 1) for _ in range(3)] + [x / norm for x in quaternion] + q
    return q, *([rng.uniform(-2, 2) for _ in range(n + robot.first)] for _ in range(2))


def largest_difference(found, expected):
    """(difference, largest entry)"""
    if isinstance(expected, list):
        pairs = [largest_difference(f, e) for f, e in zip(found, expected, strict=True)]
        return max(p[0] for p in pairs), max(p[1] for p in pairs)
    return abs(found - expected), abs(expected)


def check(file, count):
    """Status 1 if the file's figures are not what is evaluated here: to 1e-12, the file's own."""
    data = json.loads(pathlib.Path(file).read_text())
    robot = Robot(pathlib.Path(file).parent / data["urdf"], data["floating_base"])
    worst = 0.0
    for state in data["states"][:count]:
        gravity = [Decimal(x) for x in data["gravity"]]
        again = evaluate(robot, gravity, data["ee_frame"], state["q"], state["v"], state["a"], False)
        for name, value in again.items():
            if name in state:
                difference, scale = largest_difference(value, state[name])
                worst = max(worst, difference / max(scale, 1e-3))
    print(f"{file}: largest relative difference {worst:.1e}")
    return 0 if worst < 1e-12 else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", help="a URDF; with --check a file of evaluated states")
    parser.add_argument("--ee", help="link whose pose and Jacobian are given")
    parser.add_argument("--states", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--floating", action="store_true")
    parser.add_argument("--symbols", action="store_true", help="Christoffel symbols, first kind")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    if arguments.check:
        return check(arguments.file, arguments.states)
    robot = Robot(arguments.file, arguments.floating)
    answer = header(robot, arguments, arguments.file)
    rng = random.Random(arguments.seed)
    gravity = [Decimal(x) for x in ("0", "0", "-9.81")]
    answer["gravity"] = [0, 0, -9.81]
    gravity = [Decimal(x) for x in answer["gravity"]]
    answer["states"] = [evaluate(robot, gravity, arguments.ee, *random_state(robot, rng),
                                 arguments.symbols) for _ in range(arguments.states)]
    text = json.dumps(answer, indent=None, separators=(",", ":"))
    print(text.replace('{"q"', '\n{"q"').replace(',"M"', ',\n"M"').replace(',"C"', ',\n"C"'))
    return 0


if __name__ == "__main__":
    sys.exit(main())
