// Closed forms (tools/derive): the textbook's planar arm letter by letter, values against the
// mechanism at random states, Euler-Lagrange equations by GiNaC alone, refusals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>

#include "config/urdf.hpp"
#include "control/mechanism/christoffel.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tools/derive/code.hpp"
#include "tools/derive/exact.hpp"
#include "tools/derive/expressions.hpp"
#include "tools/derive/sheet.hpp"

namespace geodesic::tools::derive {
namespace {

using control::JointKind;

control::TreeDescription oracle(const std::string& robot) {
  const config::UrdfResult urdf =
      config::load_urdf(GEODESIC_TEST_DATA "/oracles/" + robot + ".urdf", false);
  EXPECT_TRUE(urdf.ok);
  return urdf.tree;
}

Eigen::VectorXd random_vector(std::mt19937& engine, int size) {
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  return Eigen::VectorXd::NullaryExpr(size, [&](Eigen::Index) { return uniform(engine); });
}

// A branch with a slide, a joint that mimics a turn by half and one that slides with a turn,
// oblique and exact axes, and something fixed.
control::TreeDescription branched(bool mimic) {
  std::mt19937 engine(7);
  control::TreeDescription tree;
  tree.name = "branched";
  tree.root_link = "base";
  tree.links.push_back({"base", {}});
  const auto add = [&](const std::string& name, const std::string& parent, JointKind kind,
                       const Eigen::Vector3d& axis, const Eigen::Vector3d& rotation_axis) {
    control::LinkDescription link{name, {}};
    link.inertia.mass_kg = 1.0 + 0.25 * static_cast<double>(tree.links.size());
    link.inertia.com_m = 0.1 * random_vector(engine, 3);
    const Eigen::Matrix3d root = 0.2 * Eigen::Matrix3d(random_vector(engine, 9).data());
    link.inertia.inertia_kg_m2 = root * root.transpose() + 0.1 * Eigen::Matrix3d::Identity();
    tree.links.push_back(link);
    control::JointDescription joint;
    joint.name = name + "_joint";
    joint.kind = kind;
    joint.parent_link = parent;
    joint.child_link = name;
    joint.axis = axis.normalized();
    joint.parent_from_joint.linear() =
        Eigen::AngleAxisd(0.7, rotation_axis.normalized()).toRotationMatrix();
    joint.parent_from_joint.translation() = 0.3 * random_vector(engine, 3);
    tree.joints.push_back(joint);
  };
  add("a", "base", JointKind::kRevolute, {0, 0, 1}, {1, 0, 0});
  add("b", "a", JointKind::kPrismatic, {1, 2, -1}, {0, 1, 1});
  add("c", "a", JointKind::kContinuous, {0, 1, 0}, {1, 1, 0});
  add("hand", "c", JointKind::kFixed, {0, 0, 1}, {1, 0, 1});
  if (!mimic) return tree;
  add("d", "c", JointKind::kRevolute, {1, 0, 0}, {0, 0, 1});
  tree.joints.back().mimic = control::MimicDescription{"c_joint", -0.5, 0.3};
  add("e", "hand", JointKind::kPrismatic, {0, 0, 1}, {0, 1, 0});
  tree.joints.back().mimic = control::MimicDescription{"a_joint", 0.25, 0.1};
  return tree;
}

struct Case {
  const char* name;
  bool letters;
  bool christoffel;
};

class Values : public testing::TestWithParam<Case> {};

TEST_P(Values, AreTheMechanisms) {
  const std::string name = GetParam().name;
  const control::TreeDescription written =
      name == "branched" || name == "mimic" ? branched(name == "mimic") : oracle(name);
  control::MechanismOptions options;
  options.rotor_inertia = Eigen::VectorXd::Constant(control::Mechanism(written, {0, 0, 0}).dof(),
                                                    name == "ur5" ? 0.0 : 0.05);
  const control::Mechanism robot(exact_tree(written).tree, {0.5, -2.0, -9.0}, options);
  control::Workspace workspace(robot);
  Wanted wanted;
  wanted.christoffel = GetParam().christoffel;
  const ClosedForm form = derive(symbolic_tree(robot, GetParam().letters), wanted, {});
  ASSERT_EQ(form.n, robot.dof());
  std::mt19937 engine(1);
  control::Christoffel expected(robot);
  for (int state = 0; state < 5; ++state) {
    const Eigen::VectorXd q = random_vector(engine, form.n);
    const Eigen::VectorXd v = random_vector(engine, form.n);
    const Eigen::MatrixXd metric = control::metric(robot, workspace, q);
    const Eigen::VectorXd bias = control::bias(robot, workspace, q, v);
    const Eigen::VectorXd gravity = control::gravity(robot, workspace, q);
    control::christoffel_symbols(robot, workspace, q, expected);
    const double scale = std::max(1.0, bias.cwiseAbs().maxCoeff());
    Eigen::VectorXd sum = gravity;
    for (int i = 0; i < form.n; ++i) {
      const auto row = static_cast<std::size_t>(i);
      EXPECT_NEAR(evaluate(form.symbols, form.gravity[row], q), gravity[i], 1e-10 * scale);
      for (int j = 0; j < form.n; ++j) {
        const auto column = static_cast<std::size_t>(j);
        EXPECT_NEAR(evaluate(form.symbols, form.metric[row][column], q), metric(i, j), 1e-10);
        for (std::size_t k = 0; wanted.christoffel && k < row; ++k) {
          const double symbol = evaluate(form.symbols, form.christoffel[row][column][k], q);
          EXPECT_NEAR(symbol, expected(i, j, static_cast<int>(k)), 1e-10 * scale);
        }
        for (int k = 0; wanted.christoffel && k < form.n; ++k) {
          sum[i] += evaluate(form.symbols,
                             form.christoffel[row][column][static_cast<std::size_t>(k)], q) *
                    v[j] * v[k];
        }
      }
    }
    if (wanted.christoffel) {
      EXPECT_LT((sum - bias).cwiseAbs().maxCoeff(), 1e-10 * scale);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, Values,
                         testing::Values(Case{"planar2r", false, true},
                                         Case{"planar2r", true, true},
                                         Case{"branched", false, true},
                                         Case{"branched", true, true}, Case{"mimic", false, true},
                                         Case{"ur5", false, true}, Case{"iiwa14", false, false}),
                         [](const auto& at) {
                           return std::string(at.param.name) + (at.param.letters ? "_letters" : "");
                         });

ClosedForm planar(bool letters, bool second_kind = false) {
  const control::Mechanism robot(exact_tree(oracle("planar2r")).tree, {0, -9.81, 0});
  Wanted wanted;
  wanted.second_kind = second_kind;
  ClosedForm form = derive(symbolic_tree(robot, letters), wanted, {});
  use_textbook_letters(form);
  return form;
}

// Spong, Hutchinson, Vidyasagar 2006, "Robot Modeling and Control", section 7.4.
TEST(PlanarArm, IsThatOfTheTextbooks) {
  ClosedForm form = planar(true);
  const std::string text = text_document(form, {"planar2r", {0, -9.81, 0}, false, {}}, {}, 12);
  const std::string formulas = text.substr(text.find("\nMetric"));
  EXPECT_EQ(formulas, R"(
Metric M(q)
  M11 = m1 lc1^2 + I1 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos q2) + I2
  M12 = M21 = m2 (lc2^2 + l1 lc2 cos q2) + I2
  M22 = m2 lc2^2 + I2

Christoffel symbols of the first kind, Γi,jk = Γi,kj = 1/2 (dMij/dqk + dMik/dqj - dMjk/dqi)
  h = -m2 l1 lc2 sin q2
  Γ1,12 = Γ1,22 = h
  Γ2,11 = -h
  all others are 0

Gravity g(q)
  g1 = (m1 lc1 + m2 l1) g cos q1 + m2 lc2 g cos(q1 + q2)
  g2 = m2 lc2 g cos(q1 + q2)

Equations of motion (Euler-Lagrange: d/dt dL/dv - dL/dq = tau, L = T - V)
  tau1 = M11 a1 + M12 a2 + h (2 v1 v2 + v2^2) + g1
  tau2 = M12 a1 + M22 a2 - h v1^2 + g2
)");
  EXPECT_NE(text.find("lc2    = 0.2 "), std::string::npos);
  EXPECT_NE(text.find("I1     = 0.0270833333333 "), std::string::npos);
}

TEST(PlanarArm, InNumbers) {
  ClosedForm form = planar(false);
  const nlohmann::ordered_json answer =
      json_document(form, {"planar2r", {0, -9.81, 0}, false, {}}, {});
  EXPECT_NEAR(std::stod(answer["M"][1][1].get<std::string>()), 0.048, 1e-16);
  EXPECT_EQ(answer["equations"][1], "tau2 = M12*a1 + M22*a2 - h*v1^2 + g2");
  EXPECT_NE(text_document(form, {"planar2r", {0, -9.81, 0}, false, {}}, {}, 6)
                .find("M12 = M21 = 0.048 + 0.09 cos q2\n"),
            std::string::npos);
}

// The second kind is M^-1 times the first.
TEST(PlanarArm, SecondKind) {
  const ClosedForm form = planar(true, true);
  const Eigen::Vector2d q(0.3, -1.1);
  Eigen::Matrix2d metric;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      metric(static_cast<int>(i), static_cast<int>(j)) =
          evaluate(form.symbols, form.metric[i][j], q);
    }
  }
  EXPECT_NEAR(evaluate(form.symbols, form.determinant, q), metric.determinant(), 1e-14);
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t k = 0; k < 2; ++k) {
      Eigen::Vector2d first;
      Eigen::Vector2d second;
      for (std::size_t i = 0; i < 2; ++i) {
        first[static_cast<int>(i)] = evaluate(form.symbols, form.christoffel[i][j][k], q);
        second[static_cast<int>(i)] = evaluate(form.symbols, form.second_kind[i][j][k], q) /
                                      evaluate(form.symbols, form.determinant, q);
      }
      EXPECT_LT((metric * second - first).cwiseAbs().maxCoeff(), 1e-13);
    }
  }
}

// d/dt dL/dv - dL/dq of L = T - V by GiNaC's rules alone, expanded to the normal form, is the sum
// of M a, the Christoffel symbols and g.
TEST(EulerLagrange, ByGinacAlone) {
  const control::Mechanism robot(branched(false), {0, 1.0, -9.81});
  ClosedForm form = derive(symbolic_tree(robot, false), {}, {});
  const auto n = static_cast<std::size_t>(form.n);
  std::vector<int> rate;
  std::vector<int> acceleration;
  for (std::size_t i = 0; i < n; ++i) {
    for (auto* list : {&rate, &acceleration}) {
      list->push_back(static_cast<int>(form.symbols.letters.size()));
      Letter letter;
      letter.name = fmt::format("x{}", form.symbols.letters.size());
      form.symbols.letters.push_back(letter);
    }
  }
  const Expressions expressions(form.symbols);
  const auto v = [&](std::size_t i) { return expressions.letter(rate[i]); };
  const auto a = [&](std::size_t i) { return expressions.letter(acceleration[i]); };
  GiNaC::ex lagrangian = -expressions.expression(form.potential);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      lagrangian += expressions.expression(form.metric[i][j]) * v(i) * v(j) / 2;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const GiNaC::ex momentum = lagrangian.diff(v(i));
    GiNaC::ex force = -expressions.derivative(lagrangian, static_cast<int>(i));
    GiNaC::ex ours = expressions.expression(form.gravity[i]);
    for (std::size_t j = 0; j < n; ++j) {
      force += expressions.derivative(momentum, static_cast<int>(j)) * v(j);
      force += momentum.diff(v(j)) * a(j);
      ours += expressions.expression(form.metric[i][j]) * a(j);
      for (std::size_t k = 0; k < n; ++k) {
        ours += expressions.expression(form.christoffel[i][j][k]) * v(j) * v(k);
      }
    }
    EXPECT_TRUE(same(expressions.polynomial(force), expressions.polynomial(ours))) << i;
  }
}

TEST(ExactFigures, AreTakenAndReported) {
  control::TreeDescription tree = oracle("planar2r");
  const double quarter = 1.57079632679;  // 4.9e-12 off
  tree.joints[1].parent_from_joint.linear() =
      Eigen::AngleAxisd(quarter, Eigen::Vector3d::UnitX()).toRotationMatrix();
  tree.joints[1].parent_from_joint.translation().y() = 3e-17;
  const ExactTree exact = exact_tree(tree);
  ASSERT_EQ(exact.notes.size(), 2U);
  EXPECT_NE(exact.notes[0].find("'joint2'"), std::string::npos);
  EXPECT_NE(exact.notes[0].find("4.9e-12"), std::string::npos);
  EXPECT_EQ(exact.tree.joints[1].parent_from_joint.linear()(1, 1), 0.0);
  EXPECT_EQ(exact.tree.joints[1].parent_from_joint.linear()(2, 1), 1.0);
  EXPECT_TRUE(exact_tree(exact.tree).notes.empty());
  // What is farther off than rounding of a file stays.
  tree.joints[1].parent_from_joint.linear() =
      Eigen::AngleAxisd(1.5707, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_NE(exact_tree(tree).tree.joints[1].parent_from_joint.linear()(1, 1), 0.0);
}

TEST(Polynomials, HaveOneForm) {
  MonomialTable table;
  const Wave a{1};
  const Wave b{1, 1};
  const Polynomial sin_a = Polynomial::sine(a);
  const Polynomial cos_a = Polynomial::cosine(a);
  const Polynomial one = multiply(table, sin_a, sin_a) + multiply(table, cos_a, cos_a);
  EXPECT_TRUE(same(one, Polynomial(1.0L)));
  EXPECT_EQ(one.terms().size(), 1U);
  // sin(a + b - a) in two ways.
  const Polynomial left =
      multiply(table, Polynomial::sine(b), cos_a) - multiply(table, Polynomial::cosine(b), sin_a);
  EXPECT_TRUE(same(left, Polynomial::sine({0, 1})));
  EXPECT_TRUE((0.1L * sin_a + 0.2L * sin_a - 0.3L * sin_a).is_zero());
  EXPECT_EQ(shortest_form(multiply(table, sin_a, Polynomial::cosine({0, 1}))).size(), 1U);
}

TEST(Refusals, NameTheJointAndTheReason) {
  control::TreeDescription tree = oracle("planar2r");
  tree.joints[1].kind = JointKind::kSpherical;
  const control::Mechanism ball(tree, {0, 0, -9.81});
  try {
    symbolic_tree(ball, false);
    FAIL();
  } catch (const std::invalid_argument& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("'joint2' is spherical"), std::string::npos);
    EXPECT_NE(std::string(refusal.what()).find("chart"), std::string::npos);
  }
  const control::Mechanism arm(exact_tree(oracle("iiwa14")).tree, {0, 0, -9.81});
  Wanted wanted;
  wanted.limit = 10'000;
  EXPECT_THROW(derive(symbolic_tree(arm, false), wanted, {}), TooLong);
  wanted.christoffel = false;
  EXPECT_LT(count_terms(derive(symbolic_tree(arm, false), wanted, {})), 10'000U);
  wanted.limit = 100;
  EXPECT_THROW(derive(symbolic_tree(arm, false), wanted, {}), TooLong);
}

// Every brace, environment and dollar is closed.
TEST(Latex, IsBalanced) {
  for (const bool letters : {false, true}) {
    ClosedForm form = planar(letters, true);
    Content content;
    content.second_kind = true;
    const std::string text = latex_document(
        form, {"planar_2r & co", {0, -9.81, 0}, true, {"joint 'a_b': 1e-12 kg·m²"}}, content, 6);
    int depth = 0;
    int dollars = 0;
    std::vector<std::string> open;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool escaped = i > 0 && text[i - 1] == '\\';
      if (text[i] == '{' && !escaped) ++depth;
      if (text[i] == '}' && !escaped) --depth;
      if (text[i] == '$' && !escaped) ++dollars;
      ASSERT_GE(depth, 0);
      if (text.compare(i, 7, "\\begin{") == 0 && (i == 0 || text[i - 1] == '\n')) {
        open.push_back(text.substr(i + 7, text.find('}', i) - i - 7));
      }
      if (text.compare(i, 5, "\\end{") == 0 && text[i - 1] == '\n') {
        ASSERT_FALSE(open.empty());
        EXPECT_EQ(open.back(), text.substr(i + 5, text.find('}', i) - i - 5));
        open.pop_back();
      }
    }
    EXPECT_EQ(depth, 0);
    EXPECT_EQ(dollars % 2, 0);
    EXPECT_TRUE(open.empty());
    EXPECT_NE(text.find("\\cos q_{2}"), std::string::npos);
    EXPECT_NE(text.find("planar\\_2r \\& co"), std::string::npos);
  }
}

}  // namespace
}  // namespace geodesic::tools::derive
