"""Runs a command under limits and writes how it ended: exit status, largest memory in bytes, processor seconds.

    launch.py RESULT ADDRESS_SPACE HANDLES FILE_SIZE COMMAND...        0 stands for no limit

A process of its own, and a small one: what is measured of a command begins with the memory of whoever started it.
"""

import os
import resource
import signal
import sys


def main():
    result, *limits = sys.argv[1:5]
    pid = os.fork()
    if pid == 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for kind, limit in zip((resource.RLIMIT_AS, resource.RLIMIT_NOFILE, resource.RLIMIT_FSIZE), map(int, limits)):
            if limit:
                resource.setrlimit(kind, (limit, limit))
        # As a shell would leave it; Python ignores both.
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        os.execv(sys.argv[5], sys.argv[5:])
    _, status, usage = os.wait4(pid, 0)
    with open(result, "w", encoding="ascii") as out:
        code = os.waitstatus_to_exitcode(status)
        out.write(f"{code} {usage.ru_maxrss * 1024} {usage.ru_utime + usage.ru_stime}")


main()
