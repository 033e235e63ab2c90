/*
 * Lets User-mode Linux run on processors with registers that it does not know.
 *
 * It reads and writes the floating-point registers of its processes by ptrace, in an area of the size
 * that it was built for. A host whose processor has more (AMX) only takes the whole area, and User-mode
 * Linux ends in a panic. Loaded before it, this ptrace reads and writes the whole area and shows the
 * part that fits; the rest stays as it is.
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#ifndef NT_X86_XSTATE
#define NT_X86_XSTATE 0x202
#endif

/* More than any processor's area. */
#define MOST 65536

static long ask(int request, pid_t pid, void *address, void *data) {
    return syscall(SYS_ptrace, (long)request, (long)pid, address, data);
}

long ptrace(enum __ptrace_request request, ...) {
    va_list list;
    va_start(list, request);
    pid_t pid = va_arg(list, pid_t);
    void *address = va_arg(list, void *);
    void *data = va_arg(list, void *);
    va_end(list);

    int reads = request == PTRACE_GETREGSET, writes = request == PTRACE_SETREGSET;
    if ((reads || writes) && (long)address == NT_X86_XSTATE) {
        static __thread char area[MOST] __attribute__((aligned(64)));
        struct iovec known = {area, sizeof area};
        struct iovec *wanted = data;
        long result = ask(PTRACE_GETREGSET, pid, address, &known);
        if (result == -1)
            return result;
        if (wanted->iov_len > known.iov_len)
            wanted->iov_len = known.iov_len;
        if (reads) {
            memcpy(wanted->iov_base, area, wanted->iov_len);
            return 0;
        }
        memcpy(area, wanted->iov_base, wanted->iov_len);
        return ask(PTRACE_SETREGSET, pid, address, &known);
    }

    /* As the C library has it: what is peeked comes back as the result. */
    long word;
    int peeks = request == PTRACE_PEEKTEXT || request == PTRACE_PEEKDATA || request == PTRACE_PEEKUSER;
    long result = ask(request, pid, address, peeks ? &word : data);
    if (peeks && result != -1) {
        errno = 0;
        return word;
    }
    return result;
}
