// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A library that is loaded before the others (LD_PRELOAD) and lets calls to the system fail in one
// program, from the beginning of its main() on. tools/faults lets each call fail in turn.
//
//   PLIANT_FAIL_PROGRAM  name of the program; without it pliant
//   PLIANT_FAIL_CALL   kind of call: open, read, readdir, stat, rename, link, fsync, write, close,
//                      mkdir, remove, truncate, lock, map, socket, bind, listen, accept, receive,
//                      send, thread
//   PLIANT_FAIL_FROM   number of the first call of this kind that fails, from 1; 0: none
//   PLIANT_FAIL_TO     number of the last one
//   PLIANT_FAIL_ERRNO  its error; 0: it reads or writes half of the bytes, and one at least
//   PLIANT_FAIL_COUNT  file that receives the number of calls when the program ends
//   PLIANT_FAIL_SHARED file of eight bytes that counts the calls of several processes
//   PLIANT_FAIL_UNDER  folder: calls for its files, for sockets and for standard output count, and
//                      no others
//   PLIANT_FAIL_LOG    file that receives a line for each call of any kind that counts: its kind,
//                      function and file, and "fails" before a call that fails
//
// Closing counts for descriptors that were written to since their last sync. Only calls between
// libraries are seen: the C library's own calls of itself are not.

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { kFails = -1, kWorks = 0, kIsShort = 1 };
enum { kDescriptors = 4096 };

static const char *s_kind = "", *s_count_file, *s_log, *s_under;
static long s_from, s_to;
static int s_errno = EIO;
static atomic_int s_runs;  // main() has begun
static atomic_long s_own_count;
static atomic_long* s_count = &s_own_count;  // calls so far
static atomic_char s_unsynced[kDescriptors];

static long number_of(const char* variable, long otherwise) {
    const char* text = getenv(variable);
    return text ? strtol(text, NULL, 10) : otherwise;
}

// Without stdio, which the program may be using.
static void write_to(const char* file, int flags, const char* text, size_t length) {
    const long opened =
        syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0600);
    if (opened < 0) return;
    syscall(SYS_write, opened, text, length);
    syscall(SYS_close, opened);
}

static void write_count(void) {
    if (!s_count_file) return;
    char text[32];
    const int length = snprintf(text, sizeof text, "%ld\n", atomic_load(s_count));
    write_to(s_count_file, O_TRUNC, text, (size_t)length);
}

// The file of a descriptor, such as "socket:[7]"; empty if there is none.
static void path_of(int file, char* path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const long length = syscall(SYS_readlinkat, AT_FDCWD, link, path, PATH_MAX - 1);
    path[length < 0 ? 0 : length] = 0;
    if (file == STDOUT_FILENO) strcpy(path, "standard output");
}

static int is_own(const char* path) {
    if (!s_under) return 1;
    static const char* const kOwn[] = {"socket:", "/memfd:pliant", "standard output"};
    for (size_t n = 0; n < sizeof kOwn / sizeof *kOwn; ++n)
        if (strncmp(path, kOwn[n], strlen(kOwn[n])) == 0) return 1;
    const size_t length = strlen(s_under);
    return strncmp(path, s_under, length) == 0 && (path[length] == '/' || path[length] == 0);
}

// Whether this call fails. Sets errno.
static int fails_for(const char* kind, const char* function, const char* path) {
    if (!atomic_load(&s_runs) || !*kind) return kWorks;
    const int is_counted = strcmp(kind, s_kind) == 0;
    if ((!is_counted && !s_log) || !is_own(path)) return kWorks;
    const long number = is_counted ? atomic_fetch_add(s_count, 1) + 1 : 0;
    const int fails = is_counted && s_from > 0 && number >= s_from && number <= s_to;
    if (s_log) {
        char line[PATH_MAX + 100];
        const int length = snprintf(line, sizeof line, "%s%s\t%s\t%s\n", fails ? "fails\t" : "",
                                    kind, function, path);
        write_to(s_log, O_APPEND, line, (size_t)length);
    }
    if (!fails) return kWorks;
    errno = s_errno;
    return s_errno ? kFails : kIsShort;
}

// Likewise, for a name beside a folder.
static int fails_at(const char* kind, const char* function, int folder, const char* name) {
    if (!atomic_load(&s_runs)) return kWorks;
    char path[2 * PATH_MAX];
    if (name[0] == '/' || !s_under) return fails_for(kind, function, name);
    if (folder != AT_FDCWD)
        path_of(folder, path);
    else if (syscall(SYS_getcwd, path, PATH_MAX) < 0)
        path[0] = 0;
    if (strcmp(name, ".") != 0) {
        const size_t length = strlen(path);
        snprintf(path + length, sizeof path - length, "/%s", name);
    }
    return fails_for(kind, function, path);
}
static int fails(const char* kind, const char* function, const char* name) {
    return fails_at(kind, function, AT_FDCWD, name);
}

// Likewise, for a descriptor.
static int fails_on(const char* kind, const char* function, int file) {
    if (!atomic_load(&s_runs)) return kWorks;
    char path[PATH_MAX];
    path_of(file, path);
    return fails_for(kind, function, path);
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
    const char *kind = getenv("PLIANT_FAIL_CALL"), *program = getenv("PLIANT_FAIL_PROGRAM");
    const char* shared = getenv("PLIANT_FAIL_SHARED");
    if (!kind || strcmp(program_invocation_short_name, program ? program : "pliant") != 0)
        return start(main, count, words, init, fini, rtld_fini, stack_end);
    s_kind = kind;
    s_log = getenv("PLIANT_FAIL_LOG");
    s_under = getenv("PLIANT_FAIL_UNDER");
    if (shared) {
        const long file = syscall(SYS_openat, AT_FDCWD, shared, O_RDWR | O_CLOEXEC);
        const long mapped =
            syscall(SYS_mmap, NULL, sizeof *s_count, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0L);
        syscall(SYS_close, file);
        if (mapped > 0) s_count = (atomic_long*)mapped;
    }
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

// A function of the file whose name is the first argument.
#define OF_NAME(kind, type, failure, name, parameters, arguments)           \
    type name parameters {                                                  \
        BEHIND(name);                                                       \
        return fails(kind, #name, path) < 0 ? (failure) : behind arguments; \
    }
#define OF_NAME_AT(kind, type, failure, name, parameters, arguments)                   \
    type name parameters {                                                             \
        BEHIND(name);                                                                  \
        return fails_at(kind, #name, folder, path) < 0 ? (failure) : behind arguments; \
    }
// A function of a descriptor.
#define OF_FILE(kind, name, parameters, arguments)                      \
    int name parameters {                                               \
        BEHIND(name);                                                   \
        return fails_on(kind, #name, file) < 0 ? -1 : behind arguments; \
    }

// Opening.

static mode_t mode_of(int flags, va_list more) {
    return flags & (O_CREAT | O_TMPFILE) ? (mode_t)va_arg(more, int) : 0;
}

#define OPEN(name)                                                              \
    int name(const char* path, int flags, ...) {                                \
        BEHIND(name);                                                           \
        va_list more;                                                           \
        va_start(more, flags);                                                  \
        const mode_t mode = mode_of(flags, more);                               \
        va_end(more);                                                           \
        return fails("open", #name, path) < 0 ? -1 : behind(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                                               \
    int name(int folder, const char* path, int flags, ...) {                                       \
        BEHIND(name);                                                                              \
        va_list more;                                                                              \
        va_start(more, flags);                                                                     \
        const mode_t mode = mode_of(flags, more);                                                  \
        va_end(more);                                                                              \
        return fails_at("open", #name, folder, path) < 0 ? -1 : behind(folder, path, flags, mode); \
    }
OPENAT(openat)
OPENAT(openat64)

OF_NAME("open", FILE*, NULL, fopen, (const char* path, const char* mode), (path, mode))
OF_NAME("open", FILE*, NULL, fopen64, (const char* path, const char* mode), (path, mode))
OF_NAME("open", DIR*, NULL, opendir, (const char* path), (path))
OF_NAME("open", int, -1, mkostemp, (char* path, int flags), (path, flags))
OF_NAME("open", int, -1, mkostemp64, (char* path, int flags), (path, flags))

int memfd_create(const char* name, unsigned flags) {
    BEHIND(memfd_create);
    char path[PATH_MAX];
    snprintf(path, sizeof path, "/memfd:%s", name);
    return fails_for("open", "memfd_create", path) < 0 ? -1 : behind(name, flags);
}

// Reading and writing of files and sockets; pipes and events work, but for standard output.

static const char* kind_of(int file, const char* of_files, const char* of_sockets) {
    static int (*behind)(int, struct stat*);
    if (!behind) behind = dlsym(RTLD_NEXT, "fstat");
    struct stat status;
    const int error = errno;
    const int known = behind(file, &status) == 0;
    errno = error;
    if (known && S_ISSOCK(status.st_mode)) return of_sockets;
    if (file == STDOUT_FILENO && s_under) return of_files;
    return known && S_ISREG(status.st_mode) && file > 2 ? of_files : "";
}

static size_t half(size_t count) {
    return count > 1 ? count / 2 : count;
}

#define READ(name, type, parameters, ...)                                          \
    type name parameters {                                                         \
        BEHIND(name);                                                              \
        const int fault = fails_on(kind_of(file, "read", "receive"), #name, file); \
        if (fault < 0) return -1;                                                  \
        if (fault > 0) count = half(count);                                        \
        return behind(file, bytes, count __VA_ARGS__);                             \
    }
#define WRITE(name, type, parameters, ...)                                       \
    type name parameters {                                                       \
        BEHIND(name);                                                            \
        const int fault = fails_on(kind_of(file, "write", "send"), #name, file); \
        if (fault < 0) return -1;                                                \
        if (fault > 0) count = half(count);                                      \
        if (file >= 0 && file < kDescriptors) s_unsynced[file] = 1;              \
        return behind(file, bytes, count __VA_ARGS__);                           \
    }
#define COMMA ,
READ(read, ssize_t, (int file, void* bytes, size_t count))
READ(pread, ssize_t, (int file, void* bytes, size_t count, off_t offset), COMMA offset)
READ(pread64, ssize_t, (int file, void* bytes, size_t count, off64_t offset), COMMA offset)
READ(recv, ssize_t, (int file, void* bytes, size_t count, int flags), COMMA flags)
WRITE(write, ssize_t, (int file, const void* bytes, size_t count))
WRITE(pwrite, ssize_t, (int file, const void* bytes, size_t count, off_t offset), COMMA offset)
WRITE(pwrite64, ssize_t, (int file, const void* bytes, size_t count, off64_t offset), COMMA offset)
WRITE(send, ssize_t, (int file, const void* bytes, size_t count, int flags), COMMA flags)

ssize_t writev(int file, const struct iovec* pieces, int count) {
    BEHIND(writev);
    const int fault = fails_on(kind_of(file, "write", "send"), "writev", file);
    if (fault < 0) return -1;
    if (file >= 0 && file < kDescriptors) s_unsynced[file] = 1;
    return behind(file, pieces, fault > 0 && count > 1 ? count - 1 : count);
}

// A stream: half of the elements are written by a call that fails, as on a full disk.
size_t fwrite(const void* bytes, size_t size, size_t count, FILE* stream) {
    BEHIND(fwrite);
    const int file = fileno(stream);
    if (file == STDOUT_FILENO || fails_on(kind_of(file, "write", ""), "fwrite", file) >= 0)
        return behind(bytes, size, count, stream);
    return behind(bytes, size, count / 2, stream);
}

static struct msghdr first_half(const struct msghdr* message, struct iovec* piece) {
    struct msghdr part = *message;
    for (size_t n = 0; n < message->msg_iovlen; ++n)
        if (message->msg_iov[n].iov_len > 0) {
            *piece = message->msg_iov[n];
            piece->iov_len = half(piece->iov_len);
            part.msg_iov = piece;
            part.msg_iovlen = 1;
            break;
        }
    return part;
}
ssize_t recvmsg(int file, struct msghdr* message, int flags) {
    BEHIND(recvmsg);
    const int fault = fails_on("receive", "recvmsg", file);
    if (fault < 0) return -1;
    struct iovec piece;
    struct msghdr part = first_half(message, &piece);
    return behind(file, fault > 0 ? &part : message, flags);
}
ssize_t sendmsg(int file, const struct msghdr* message, int flags) {
    BEHIND(sendmsg);
    const int fault = fails_on("send", "sendmsg", file);
    if (fault < 0) return -1;
    struct iovec piece;
    const struct msghdr part = first_half(message, &piece);
    return behind(file, fault > 0 ? &part : message, flags);
}

#define READDIR(name, type)                                                             \
    struct type* name(DIR* listing) {                                                   \
        BEHIND(name);                                                                   \
        return fails_on("readdir", #name, dirfd(listing)) < 0 ? NULL : behind(listing); \
    }
READDIR(readdir, dirent)
READDIR(readdir64, dirent64)

// A descriptor that failed to close is closed.
int close(int file) {
    BEHIND(close);
    const int is_unsynced =
        file >= 0 && file < kDescriptors && atomic_exchange(&s_unsynced[file], 0);
    const int fault = is_unsynced && *kind_of(file, "f", "") ? fails_on("close", "close", file) : 0;
    const int error = errno, result = behind(file);
    if (fault < 0) errno = error;
    return fault < 0 ? -1 : result;
}
int fclose(FILE* stream) {
    BEHIND(fclose);
    const int file = fileno(stream);
    // A stream writes by itself.
    const int flags = (int)syscall(SYS_fcntl, file, F_GETFL);
    const int is_written = flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
    const int fault = is_written && *kind_of(file, "f", "") ? fails_on("close", "fclose", file) : 0;
    if (file >= 0 && file < kDescriptors) s_unsynced[file] = 0;
    const int error = errno, result = behind(stream);
    if (fault < 0) errno = error;
    return fault < 0 ? EOF : result;
}

// The state of files.

OF_NAME("stat", int, -1, stat, (const char* path, struct stat* status), (path, status))
OF_NAME("stat", int, -1, stat64, (const char* path, struct stat64* status), (path, status))
OF_NAME("stat", int, -1, lstat, (const char* path, struct stat* status), (path, status))
OF_NAME("stat", int, -1, lstat64, (const char* path, struct stat64* status), (path, status))
OF_FILE("stat", fstat, (int file, struct stat* status), (file, status))
OF_FILE("stat", fstat64, (int file, struct stat64* status), (file, status))
OF_NAME_AT("stat", int, -1, fstatat, (int folder, const char* path, struct stat* status, int flags),
           (folder, path, status, flags))
OF_NAME_AT("stat", int, -1, fstatat64,
           (int folder, const char* path, struct stat64* status, int flags),
           (folder, path, status, flags))

// Names and folders.

OF_NAME("rename", int, -1, rename, (const char* path, const char* to), (path, to))
OF_NAME("link", int, -1, link, (const char* path, const char* to), (path, to))
OF_NAME("mkdir", int, -1, mkdir, (const char* path, mode_t mode), (path, mode))
OF_NAME("mkdir", char*, NULL, mkdtemp, (char* path), (path))
OF_NAME("remove", int, -1, unlink, (const char* path), (path))
OF_NAME("remove", int, -1, rmdir, (const char* path), (path))
OF_NAME("remove", int, -1, remove, (const char* path), (path))
OF_NAME_AT("remove", int, -1, unlinkat, (int folder, const char* path, int flags),
           (folder, path, flags))
OF_FILE("truncate", ftruncate, (int file, off_t size), (file, size))
OF_FILE("truncate", ftruncate64, (int file, off64_t size), (file, size))
OF_FILE("lock", flock, (int file, int operation), (file, operation))

#define MAP(name, type)                                                               \
    void* name(void* at, size_t size, int access, int flags, int file, type offset) { \
        BEHIND(name);                                                                 \
        return file >= 0 && fails_on("map", #name, file) < 0                          \
                   ? MAP_FAILED                                                       \
                   : behind(at, size, access, flags, file, offset);                   \
    }
MAP(mmap, off_t)
MAP(mmap64, off64_t)

// To the disk.

#define SYNC(name)                                                  \
    int name(int file) {                                            \
        BEHIND(name);                                               \
        if (fails_on("fsync", #name, file) < 0) return -1;          \
        if (file >= 0 && file < kDescriptors) s_unsynced[file] = 0; \
        return behind(file);                                        \
    }
SYNC(fsync)
SYNC(fdatasync)
SYNC(syncfs)

// Sockets.

int socket(int domain, int type, int protocol) {
    BEHIND(socket);
    return fails_for("socket", "socket", "socket:") < 0 ? -1 : behind(domain, type, protocol);
}
int socketpair(int domain, int type, int protocol, int ends[2]) {
    BEHIND(socketpair);
    return fails_for("socket", "socketpair", "socket:") < 0 ? -1
                                                            : behind(domain, type, protocol, ends);
}
OF_FILE("bind", bind, (int file, const struct sockaddr* address, socklen_t length),
        (file, address, length))
OF_FILE("listen", listen, (int file, int waiting), (file, waiting))
// An aborted connection is no longer waiting.
static int failed_accept(int connection) {
    if (connection >= 0) syscall(SYS_close, connection);
    errno = s_errno;
    return -1;
}
int accept(int file, struct sockaddr* address, socklen_t* length) {
    BEHIND(accept);
    if (fails_on("accept", "accept", file) == 0) return behind(file, address, length);
    return failed_accept(s_errno == ECONNABORTED ? behind(file, address, length) : -1);
}
int accept4(int file, struct sockaddr* address, socklen_t* length, int flags) {
    BEHIND(accept4);
    if (fails_on("accept", "accept4", file) == 0) return behind(file, address, length, flags);
    return failed_accept(s_errno == ECONNABORTED ? behind(file, address, length, flags) : -1);
}

// Threads.

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*),
                   void* argument) {
    BEHIND(pthread_create);
    return fails_for("thread", "pthread_create", s_under ? s_under : "") < 0
               ? s_errno
               : behind(thread, attributes, work, argument);
}
