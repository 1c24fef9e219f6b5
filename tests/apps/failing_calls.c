// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A library that is loaded before the others (LD_PRELOAD) and lets calls to the system fail in a
// program named pliant, from the beginning of its main() on:
//
//   PLIANT_FAIL_CALL   kind of call: open, read, readdir, stat, rename, fsync, thread, write, link
//   PLIANT_FAIL_FROM   number of the first call of this kind that fails, from 1; 0: none
//   PLIANT_FAIL_TO     number of the last one
//   PLIANT_FAIL_ERRNO  its error
//   PLIANT_FAIL_COUNT  file that receives the number of calls when the program ends
//
// Only calls between libraries are seen: the C library's own calls of itself are not.

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static const char* s_kind = "";
static const char* s_count_file;
static long s_from, s_to;
static int s_errno = EIO;
static atomic_int s_runs;    // main() has begun
static atomic_long s_count;  // calls so far

static long number_of(const char* variable, long otherwise) {
    const char* text = getenv(variable);
    return text ? strtol(text, NULL, 10) : otherwise;
}

// Whether this call fails.
static int fails(const char* kind) {
    if (!atomic_load(&s_runs) || strcmp(kind, s_kind) != 0) return 0;
    const long number = atomic_fetch_add(&s_count, 1) + 1;
    if (s_from <= 0 || number < s_from || number > s_to) return 0;
    errno = s_errno;
    return 1;
}

// Without stdio, which the program may be using.
static void write_count(void) {
    if (!s_count_file) return;
    char text[32];
    const int length = snprintf(text, sizeof text, "%ld\n", atomic_load(&s_count));
    const long file =
        syscall(SYS_openat, AT_FDCWD, s_count_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0) return;
    syscall(SYS_write, file, text, length);
    syscall(SYS_close, file);
}

typedef int (*Main)(int, char**, char**);
static Main s_main;

static int counted_main(int count, char** words, char** environment) {
    atexit(write_count);
    atomic_store(&s_runs, 1);
    return s_main(count, words, environment);
}

int __libc_start_main(Main main, int count, char** words, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void* stack_end) {
    typedef int (*Start)(Main, int, char**, void (*)(void), void (*)(void), void (*)(void), void*);
    const Start start = (Start)dlsym(RTLD_NEXT, "__libc_start_main");
    const char* kind = getenv("PLIANT_FAIL_CALL");
    if (!kind || strcmp(program_invocation_short_name, "pliant") != 0)
        return start(main, count, words, init, fini, rtld_fini, stack_end);
    s_kind = kind;
    s_from = number_of("PLIANT_FAIL_FROM", 0);
    s_to = number_of("PLIANT_FAIL_TO", s_from);
    s_errno = (int)number_of("PLIANT_FAIL_ERRNO", EIO);
    s_count_file = getenv("PLIANT_FAIL_COUNT");
    s_main = main;
    return start(counted_main, count, words, init, fini, rtld_fini, stack_end);
}

void _exit(int status) {
    write_count();
    for (;;) syscall(SYS_exit_group, status);
}

// The function of this name behind this library.
#define BEHIND(name)                 \
    static __typeof__(&name) behind; \
    if (!behind) behind = dlsym(RTLD_NEXT, #name)

// Opening.

static mode_t mode_of(int flags, va_list more) {
    return flags & (O_CREAT | O_TMPFILE) ? (mode_t)va_arg(more, int) : 0;
}

#define OPEN(name)                                             \
    int name(const char* path, int flags, ...) {               \
        BEHIND(name);                                          \
        va_list more;                                          \
        va_start(more, flags);                                 \
        const mode_t mode = mode_of(flags, more);              \
        va_end(more);                                          \
        return fails("open") ? -1 : behind(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                   \
    int name(int folder, const char* path, int flags, ...) {           \
        BEHIND(name);                                                  \
        va_list more;                                                  \
        va_start(more, flags);                                         \
        const mode_t mode = mode_of(flags, more);                      \
        va_end(more);                                                  \
        return fails("open") ? -1 : behind(folder, path, flags, mode); \
    }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(name)                                       \
    FILE* name(const char* path, const char* mode) {      \
        BEHIND(name);                                     \
        return fails("open") ? NULL : behind(path, mode); \
    }
FOPEN(fopen)
FOPEN(fopen64)

DIR* opendir(const char* path) {
    BEHIND(opendir);
    return fails("open") ? NULL : behind(path);
}

// Reading and writing of files; streams, pipes and events work.

static int is_file(int file) {
    static int (*behind)(int, struct stat*);
    if (!behind) behind = dlsym(RTLD_NEXT, "fstat");
    struct stat status;
    return behind(file, &status) == 0 && S_ISREG(status.st_mode) && file > 2;
}

ssize_t read(int file, void* bytes, size_t count) {
    BEHIND(read);
    return is_file(file) && fails("read") ? -1 : behind(file, bytes, count);
}

#define PREAD(name)                                                     \
    ssize_t name(int file, void* bytes, size_t count, off_t offset) {   \
        BEHIND(name);                                                   \
        return fails("read") ? -1 : behind(file, bytes, count, offset); \
    }
PREAD(pread)
PREAD(pread64)

struct dirent* readdir(DIR* folder) {
    BEHIND(readdir);
    return fails("readdir") ? NULL : behind(folder);
}
struct dirent64* readdir64(DIR* folder) {
    BEHIND(readdir64);
    return fails("readdir") ? NULL : behind(folder);
}

ssize_t write(int file, const void* bytes, size_t count) {
    BEHIND(write);
    return is_file(file) && fails("write") ? -1 : behind(file, bytes, count);
}
ssize_t writev(int file, const struct iovec* pieces, int count) {
    BEHIND(writev);
    return is_file(file) && fails("write") ? -1 : behind(file, pieces, count);
}

// The state of files.

#define STAT(name, type)                                  \
    int name(const char* path, struct type* status) {     \
        BEHIND(name);                                     \
        return fails("stat") ? -1 : behind(path, status); \
    }
STAT(stat, stat)
STAT(stat64, stat64)
STAT(lstat, stat)
STAT(lstat64, stat64)

#define FSTAT(name, type)                                 \
    int name(int file, struct type* status) {             \
        BEHIND(name);                                     \
        return fails("stat") ? -1 : behind(file, status); \
    }
FSTAT(fstat, stat)
FSTAT(fstat64, stat64)

#define FSTATAT(name, type)                                                  \
    int name(int folder, const char* path, struct type* status, int flags) { \
        BEHIND(name);                                                        \
        return fails("stat") ? -1 : behind(folder, path, status, flags);     \
    }
FSTATAT(fstatat, stat)
FSTATAT(fstatat64, stat64)

// Renaming.

int rename(const char* from, const char* to) {
    BEHIND(rename);
    return fails("rename") ? -1 : behind(from, to);
}
int link(const char* from, const char* to) {
    BEHIND(link);
    return fails("link") ? -1 : behind(from, to);
}

// To the disk.

int fsync(int file) {
    BEHIND(fsync);
    return fails("fsync") ? -1 : behind(file);
}
int fdatasync(int file) {
    BEHIND(fdatasync);
    return fails("fsync") ? -1 : behind(file);
}
int syncfs(int file) {
    BEHIND(syncfs);
    return fails("fsync") ? -1 : behind(file);
}

// Threads.

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*),
                   void* argument) {
    BEHIND(pthread_create);
    return fails("thread") ? s_errno : behind(thread, attributes, work, argument);
}
