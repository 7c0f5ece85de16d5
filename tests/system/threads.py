"""Stops, kills or misleads a single thread of a program from outside, by ptrace: no program needs a
hook for it. Only for threads that wait in a system call."""
import ctypes
import os
import pathlib
import platform
import time

_SEIZE, _INTERRUPT, _DETACH, _GET, _SET = 0x4206, 0x4207, 17, 0x4204, 0x4205
_PRSTATUS = 1
_ALL_CHILDREN = 0x40000000  # __WALL: threads too

# machine: (registers, the one of the call's number, of its first argument, of the next instruction,
# bytes of the instruction that calls the kernel, number of exit, number of getpid)
_MACHINES = {"x86_64": (27, 10, 14, 16, b"\x0f\x05", 60, 39),
             "aarch64": (34, 8, 0, 32, b"\x01\x00\x00\xd4", 93, 172)}
_WORDS, _CALL, _ARGUMENT, _NEXT, _INSTRUCTION, EXIT, GETPID = _MACHINES[platform.machine()]
_INTERRUPTED = 15  # x86: which call was interrupted; -1 keeps the kernel from making it again

_libc = ctypes.CDLL(None, use_errno=True)
_libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
_libc.ptrace.restype = ctypes.c_long


class _Vector(ctypes.Structure):
    _fields_ = [("base", ctypes.c_void_p), ("length", ctypes.c_size_t)]


def _ptrace(request, thread, address=None, data=None):
    if _libc.ptrace(request, thread, address, data) < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"ptrace {request}: {os.strerror(number)}")


def find(process, name):
    """The thread of a process that has this name."""
    for task in pathlib.Path(f"/proc/{process}/task").iterdir():
        if (task / "comm").read_text(encoding="utf-8").strip() == name:
            return int(task.name)
    raise LookupError(f"process {process} has no thread {name}")


class Stopped:
    """A thread that stands still from construction to resume(); the others go on."""

    def __init__(self, process, name):
        self.process = process
        self.thread = find(process, name)
        _ptrace(_SEIZE, self.thread)
        self._interrupt()

    def _interrupt(self):
        _ptrace(_INTERRUPT, self.thread)
        os.waitpid(self.thread, _ALL_CHILDREN)

    def _registers(self, request, values):
        vector = _Vector(ctypes.addressof(values), ctypes.sizeof(values))
        _ptrace(request, self.thread, ctypes.c_void_p(_PRSTATUS), ctypes.addressof(vector))

    def resume(self):
        _ptrace(_DETACH, self.thread)

    def resume_with_call(self, number):
        """Lets it go on, but with a system call of our choice (first argument 0) in place of the
        one it waits in."""
        values = (ctypes.c_ulonglong * _WORDS)()
        for _ in range(1000):
            self._registers(_GET, values)
            with open(f"/proc/{self.process}/mem", "rb") as memory:
                memory.seek(values[_NEXT] - len(_INSTRUCTION))
                if memory.read(len(_INSTRUCTION)) == _INSTRUCTION:
                    break
            _ptrace(7, self.thread)  # PTRACE_CONT: it was not in a call
            time.sleep(0.001)
            self._interrupt()
        values[_CALL] = number
        values[_ARGUMENT] = 0
        values[_NEXT] -= len(_INSTRUCTION)
        if platform.machine() == "x86_64":
            values[_INTERRUPTED] = 2**64 - 1
        self._registers(_SET, values)
        self.resume()

    def wait_for_end_of(self, program, seconds):
        """Exit status of the program, which cannot be had before its stopped thread is buried."""
        end = time.monotonic() + seconds
        buried = False
        while program.running() and time.monotonic() < end:
            if not buried:
                try:
                    done, status = os.waitpid(self.thread, _ALL_CHILDREN | os.WNOHANG)
                    buried = done != 0 and not os.WIFSTOPPED(status)
                except ChildProcessError:
                    buried = True
            time.sleep(0.02)
        return program.wait(1)
