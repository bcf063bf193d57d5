/* An FMI 2.0 FMU that misbehaves: the file resources/kind beside it says how and where, as BEHAVIOUR@HOOK.

   y counts the steps. At the hook `step` it misbehaves in the 50th step, at `every` in each one. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#define EXPORT __attribute__((visibility("default")))
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished, *environment;
} Callbacks;
typedef struct {
    double u, y, t;
    const Callbacks *callbacks;
    int steps, status;
} Instance;

static char behaviour[64], hook[32];

static void say(Instance *i, int status, const char *text) {
    if (i && i->callbacks) i->callbacks->logger(i->callbacks->environment, "bad", status, "logStatus", text);
}
static void nap(void) { usleep(1000); }
static void *spin(void *x) {
    for (;;) nap();
    return x;
}
static void *crash_later(void *x) {
    usleep(30000);
    *(volatile int *)8 = 1;
    return x;
}
static void *log_there(void *x) {
    say(x, 1, "from another thread");
    return NULL;
}
static void on_signal(int s) { (void)s; }
static void spin_at_exit(void) { spin(NULL); }
static void thread(void *(*what)(void *), void *x) {
    pthread_t id;
    pthread_create(&id, NULL, what, x);
}
static int deep(int n) {
    volatile char block[4096];
    block[n % 4096] = (char)n;
    return deep(n + 1) + block[0];
}
static void into_descriptors(const void *data, size_t n) {
    for (int fd = 3; fd < 40; fd++)
        if (fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) == 0 && write(fd, data, n)) continue;
}
static void file(const char *name) {
    FILE *f = fopen(name, "w");
    if (f) fclose(f);
}

static int is(const char *name) { return strcmp(behaviour, name) == 0; }

/* What is chosen; only some of it comes back. */
static void misbehave(Instance *i) {
    if (is("segv")) *(volatile int *)8 = 1;
    if (is("null-call")) ((void (*)(void))(intptr_t)0)();
    if (is("abort")) abort();
    if (is("divide")) {
        raise(SIGFPE);
    }
    if (is("illegal")) __builtin_trap();
    if (is("bus")) raise(SIGBUS);
    if (is("stack")) deep(0);
    if (is("exit0")) exit(0);
    if (is("exit3")) exit(3);
    if (is("_exit0")) _exit(0);
    if (is("_exit3")) _exit(3);
    if (is("kill")) kill(getpid(), SIGKILL);
    if (is("terminate")) kill(getpid(), SIGTERM);
    if (is("hang")) for (;;) nap();
    if (is("busy")) for (volatile int n = 0;; n++) {}
    if (is("deaf-hang")) {
        for (int s = 1; s < 31; s++) signal(s, SIG_IGN);
#ifdef __linux__
        prctl(PR_SET_PDEATHSIG, 0);
#endif
        for (;;) nap();
    }
    if (is("double-free")) {
        void *p = malloc(32);
        free(p), free(p);
    }
    if (is("scribble")) {
        char *p = malloc(32);
        memset(p, 0xa5, 100000);
        free(p), free(malloc(5000));
    }
    if (is("memory"))
        for (;;) {
            void *p = malloc(64 << 20);
            if (!p) {
                i->status = 3;
                break;
            }
            memset(p, 1, 64 << 20);
        }
    if (is("chdir") && chdir("/")) exit(9);
    if (is("umask")) umask(0777);
    if (is("environment")) setenv("TMPDIR", "/nowhere", 1), setenv("HOME", "/nowhere", 1), unsetenv("PATH");
    if (is("locale")) setlocale(LC_ALL, "de_DE.UTF-8") || setlocale(LC_ALL, "C.UTF-8");
    if (is("rounding")) fesetround(FE_UPWARD);
#if defined __x86_64__
    if (is("flush")) __builtin_ia32_ldmxcsr(0x9fc0);
#endif
#ifdef __linux__
    if (is("traps")) feenableexcept(FE_ALL_EXCEPT);
    if (is("orphan")) prctl(PR_SET_PDEATHSIG, 0);
#endif
    if (is("handlers")) signal(SIGINT, on_signal), signal(SIGTERM, on_signal);
    if (is("ignore")) for (int s = 1; s < 31; s++) signal(s, SIG_IGN);
    if (is("alarm")) alarm(1);
    if (is("timer")) {
        struct itimerval every = {{0, 1000}, {0, 1000}};
        signal(SIGALRM, on_signal), setitimer(ITIMER_REAL, &every, NULL);
    }
    if (is("close-all")) for (int fd = 0; fd < 1024; fd++) close(fd);
    if (is("close-0")) close(0), close(1);
    if (is("no-files")) {
        struct rlimit few = {3, 3};
        setrlimit(RLIMIT_NOFILE, &few);
    }
    if (is("no-size")) {
        struct rlimit none = {0, 0};
        signal(SIGXFSZ, SIG_IGN), setrlimit(RLIMIT_FSIZE, &none);
    }
    if (is("stdout")) printf("{\"a\": evil}\n"), fflush(stdout);
    if (is("stdout-later")) printf("not flushed ");
    if (is("stderr")) for (int n = 0; n < 1000; n++) fprintf(stderr, "0123456789abcdef\n");
    if (is("files")) file("left.txt"), file("left-too.txt");
    if (is("fork")) {
        if (fork() == 0) sleep(30), _exit(0);
    }
    if (is("daemon")) {
        if (fork() == 0) {
            setsid();
            if (fork() == 0) sleep(30);
            _exit(0);
        }
    }
    if (is("twin")) fork();
    if (is("threads")) for (int n = 0; n < 50; n++) thread(spin, NULL);
    if (is("thread-crash")) thread(crash_later, NULL);
    if (is("thread-log")) thread(log_there, i), nap();
    if (is("at-exit")) atexit(spin_at_exit);
    if (is("parent")) kill(getppid(), SIGUSR1);
    if (is("parent-term")) kill(getppid(), SIGTERM);
    if (is("garbage")) into_descriptors("\0\0\0\5hello", 9);
    if (is("half-frame")) {
        into_descriptors("GCRU\1\144\0\0\20\0\0\0", 12);
        for (;;) nap();
    }
    if (is("false-frame")) into_descriptors("GCRU\1\144\0\0\0\0\0\0\377\377\0\0\0\0\0\0", 20);
    if (is("pickle")) into_descriptors("\0\0\0\60c__builtin__\nexec\n(S'open(\"RAN\",\"w\").write(\"x\")'\ntR.", 52);
    if (is("nan")) i->y = NAN;
    if (is("infinite")) i->y = INFINITY;
    if (is("huge")) i->y = i->steps % 2 ? 1e308 : -1e308;
    if (strncmp(behaviour, "status", 6) == 0) i->status = atoi(behaviour + 6);
    if (is("log-escape")) say(i, 3, "\x1b[2J\x1b[31m\xff\xfe[bold]"), i->status = 3;
    if (is("log-null")) i->callbacks->logger(i->callbacks->environment, NULL, 3, NULL, NULL), i->status = 3;
    if (is("log-nobody")) i->callbacks->logger(NULL, "x", 3, "x", "to nobody"), i->status = 3;
    if (is("log-percent")) say(i, 3, "%s%s%s%n%n%d"), i->status = 3;
    if (is("log-status")) say(i, 77, "status 77"), say(i, -5, "status -5"), i->status = 3;
    if (is("log-million")) for (int n = 0; n < 1000000; n++) say(i, 1, "again");
    if (is("log-long")) {
        char *text = malloc(1 << 20);
        memset(text, 'A', (1 << 20) - 1), text[(1 << 20) - 1] = 0;
        i->callbacks->logger(i->callbacks->environment, "x", 3, "x", "%s", text), say(i, 3, text), free(text), i->status = 3;
    }
}

static void at(const char *where, Instance *i) {
    if (strcmp(hook, where) == 0) misbehave(i);
}

__attribute__((constructor)) static void loaded(void) {
    Dl_info info;
    char path[4096], kind[96] = "";
    if (!dladdr((void *)(intptr_t)misbehave, &info)) return;
    snprintf(path, sizeof path, "%s", info.dli_fname);
    for (int up = 0; up < 3; up++) {
        char *slash = strrchr(path, '/');
        if (slash) *slash = 0;
    }
    snprintf(path + strlen(path), sizeof path - strlen(path), "/resources/kind");
    FILE *f = fopen(path, "r");
    if (f && fgets(kind, sizeof kind, f)) sscanf(kind, "%63[^@]@%31s", behaviour, hook);
    if (f) fclose(f);
    at("load", NULL);
}
__attribute__((destructor)) static void unloaded(void) { at("unload", NULL); }

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *what) { return (void)c, (void)on, (void)n, (void)what, 0; }
EXPORT void *fmi2Instantiate(const char *n, int type, const char *guid, const char *where, const Callbacks *callbacks, int v, int log) {
    (void)n, (void)type, (void)guid, (void)where, (void)v, (void)log;
    Instance *i = calloc(1, sizeof *i);
    i->callbacks = callbacks;
    if (is("nothing")) return NULL;
    at("instantiate", i);
    return i;
}
EXPORT void fmi2FreeInstance(void *c) { at("free", c), free(c); }
EXPORT int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) {
    return (void)c, (void)a, (void)b, (void)d, (void)e, (void)f, 0;
}
EXPORT int fmi2EnterInitializationMode(void *c) { return at("initialize", c), ((Instance *)c)->status; }
EXPORT int fmi2ExitInitializationMode(void *c) { return (void)c, 0; }
EXPORT int fmi2Terminate(void *c) { return at("terminate", c), 0; }
EXPORT int fmi2Reset(void *c) { return (void)c, 0; }
EXPORT int fmi2GetReal(void *c, const unsigned *r, size_t n, double *values) {
    Instance *i = c;
    if (i->steps == 50) at("get", i);
    for (size_t k = 0; k < n; k++) values[k] = r[k] == 0 ? i->u : i->y;
    return i->status;
}
EXPORT int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++)
        if (r[k] == 0) ((Instance *)c)->u = values[k];
    return 0;
}
EXPORT int fmi2GetRealStatus(void *c, int kind, double *value) { return (void)kind, *value = ((Instance *)c)->t, 0; }
EXPORT int fmi2GetBooleanStatus(void *c, int kind, int *value) { return (void)c, (void)kind, *value = 0, 0; }
EXPORT int fmi2DoStep(void *c, double t, double h, int final) {
    Instance *i = c;
    (void)final;
    i->steps++, i->y = i->steps, i->t = t + h;
    if (i->steps == 50) at("step", i);
    at("every", i);
    return i->status;
}
