/* Preloaded into a program: writes down, in their order, the calls by which it changes files below a folder.

   RECORD_UNDER   the folder, as realpath() gives it
   RECORD_TO      the record, a file elsewhere

   Each call that succeeded is a record: the struct below in the machine's byte order, then a path, another path, data. What the
   C library does inside itself (fopen) is not seen: who reads the record compares its end with the folder. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#pragma GCC visibility push(default)

struct call {
    char what[4]; /* C created, W written, Z size, R renamed, U removed, S forced to the disk */
    uint32_t path, other;
    uint32_t unused;
    uint64_t file; /* inode */
    int64_t at;    /* where data begins, or the size */
    uint64_t size; /* of data */
};

static int record = -1;

static const char *under(void) { return getenv("RECORD_UNDER"); }

static int inside(const char *path) {
    size_t n = under() ? strlen(under()) : 0;
    return n && !strncmp(path, under(), n) && (path[n] == '/' || !path[n]);
}

static void say(char what, const char *path, const char *other, uint64_t file, int64_t at, const void *data, size_t size) {
    int before = errno;
    struct call told = {{what}, (uint32_t)strlen(path), (uint32_t)strlen(other), 0, file, at, size};
    struct iovec parts[] = {
        {&told, sizeof told}, {(void *)path, told.path}, {(void *)other, told.other}, {(void *)data, size}};
    if (record < 0)
        record = (int)syscall(SYS_openat, AT_FDCWD, getenv("RECORD_TO"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (syscall(SYS_writev, record, parts, 4) != (long)(sizeof told + told.path + told.other + size)) abort();
    errno = before;
}

/* The path and inode of an open file; whether it is one of those that are watched. */
static int of(int fd, char *path, struct stat *about) {
    char link[64];
    int before = errno;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, PATH_MAX - 1);
    path[n > 0 ? n : 0] = 0;
    int watched = n > 0 && inside(path) && !fstat(fd, about) && (S_ISREG(about->st_mode) || S_ISDIR(about->st_mode));
    errno = before;
    return watched;
}

/* The real path of a name, which need not exist. */
static int named(int folder, const char *name, char *path) {
    char place[PATH_MAX], whole[PATH_MAX];
    int before = errno;
    if (name[0] == '/' || folder == AT_FDCWD)
        snprintf(whole, sizeof whole, "%s", name);
    else {
        char link[64], base[PATH_MAX];
        snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        ssize_t n = readlink(link, base, sizeof base - 1);
        base[n > 0 ? n : 0] = 0;
        if (snprintf(whole, sizeof whole, "%s/%s", base, name) >= (int)sizeof whole) return 0;
    }
    char *slash = strrchr(whole, '/');
    const char *last = slash ? slash + 1 : whole;
    snprintf(place, sizeof place, "%.*s", slash ? (int)(slash - whole) : 1, slash ? whole : ".");
    int watched = 0;
    if (realpath(*place ? place : "/", path)) {
        size_t n = strlen(path);
        watched = snprintf(path + n, PATH_MAX - n, "/%s", last) < (int)(PATH_MAX - n) && inside(path);
    }
    errno = before;
    return watched;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int opened(int (*real)(int, const char *, int, ...), int folder, const char *name, int flags, mode_t mode) {
    struct stat about;
    char path[PATH_MAX];
    int before = errno, there = !fstatat(folder, name, &about, 0);
    errno = before;
    int fd = real(folder, name, flags, mode);
    if (fd >= 0 && of(fd, path, &about) && S_ISREG(about.st_mode)) {
        if (!there) say('C', path, "", about.st_ino, 0, "", 0);
        else if (flags & O_TRUNC) say('Z', path, "", about.st_ino, 0, "", 0);
    }
    return fd;
}

#define OPEN(name, at)                                                   \
    int name(const char *path, int flags, ...) {                         \
        va_list rest;                                                    \
        va_start(rest, flags);                                           \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
        va_end(rest);                                                    \
        return opened(REAL(at), AT_FDCWD, path, flags, mode);            \
    }
OPEN(open, openat)
OPEN(open64, openat64)

#define OPENAT(name)                                                     \
    int name(int folder, const char *path, int flags, ...) {             \
        va_list rest;                                                    \
        va_start(rest, flags);                                           \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0; \
        va_end(rest);                                                    \
        return opened(REAL(name), folder, path, flags, mode);            \
    }
OPENAT(openat)
OPENAT(openat64)

static void written(int fd, const void *data, ssize_t n, int64_t at) {
    struct stat about;
    char path[PATH_MAX];
    if (n > 0 && of(fd, path, &about)) say('W', path, "", about.st_ino, at < 0 ? lseek(fd, 0, SEEK_CUR) - n : at, data, (size_t)n);
}

ssize_t write(int fd, const void *data, size_t size) {
    ssize_t n = REAL(write)(fd, data, size);
    written(fd, data, n, -1);
    return n;
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t at) {
    ssize_t n = REAL(pwrite)(fd, data, size, at);
    written(fd, data, n, at);
    return n;
}

ssize_t pwrite64(int fd, const void *data, size_t size, off64_t at) { return pwrite(fd, data, size, at); }

static void sized(int fd, int result, int64_t size) {
    struct stat about;
    char path[PATH_MAX];
    if (!result && of(fd, path, &about)) say('Z', path, "", about.st_ino, size, "", 0);
}

int ftruncate(int fd, off_t size) {
    int result = REAL(ftruncate)(fd, size);
    sized(fd, result, size);
    return result;
}

int ftruncate64(int fd, off64_t size) { return ftruncate(fd, size); }

static void forced(int fd, int result) {
    struct stat about;
    char path[PATH_MAX];
    if (!result && of(fd, path, &about)) say('S', path, "", about.st_ino, 0, "", 0);
}

int fsync(int fd) {
    int result = REAL(fsync)(fd);
    forced(fd, result);
    return result;
}

int fdatasync(int fd) {
    int result = REAL(fdatasync)(fd);
    forced(fd, result);
    return result;
}

int renameat(int from, const char *old, int to, const char *name) {
    char first[PATH_MAX], second[PATH_MAX];
    int watched = named(from, old, first) && named(to, name, second);
    int result = REAL(renameat)(from, old, to, name);
    if (!result && watched) say('R', first, second, 0, 0, "", 0);
    return result;
}

int rename(const char *old, const char *name) { return renameat(AT_FDCWD, old, AT_FDCWD, name); }

int unlinkat(int folder, const char *name, int flags) {
    char path[PATH_MAX];
    int watched = named(folder, name, path);
    int result = REAL(unlinkat)(folder, name, flags);
    if (!result && watched) say('U', path, "", 0, 0, "", 0);
    return result;
}

int unlink(const char *name) { return unlinkat(AT_FDCWD, name, 0); }
