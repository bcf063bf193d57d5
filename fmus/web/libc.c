/* What the C code of an FMU asks of a C library, for WebAssembly, where there is none: memory, text, a clock that stands still.
   An instance of the module serves one run, so memory grows and what was freed is given out again by size. */

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#define PAGE 65536u
#define CLASSES 32

/* Before every block stands its size class, the power of two that it was rounded up to. Blocks stand on 16 bytes. */
typedef struct Block {
    union {
        struct Block *next;
        uint64_t class;
    } is;
    uint64_t pad;
} Block;

extern unsigned char __heap_base;
static uintptr_t top;
static Block *freed[CLASSES];

__attribute__((export_name("malloc"))) void *malloc(size_t size) {
    unsigned class = 4;
    while (class < CLASSES - 1 && ((size_t)1 << class) < size) class++;
    if (((size_t)1 << class) < size) return NULL;
    Block *block = freed[class];
    if (block) {
        freed[class] = block->is.next;
    } else {
        if (!top) top = ((uintptr_t)&__heap_base + 15) & ~(uintptr_t)15;
        const uintptr_t whole = sizeof(Block) + ((size_t)1 << class), have = __builtin_wasm_memory_size(0) * PAGE;
        if (top + whole > have && __builtin_wasm_memory_grow(0, (top + whole - have + PAGE - 1) / PAGE) == (size_t)-1) return NULL;
        block = (Block *)top;
        top += whole;
    }
    block->is.class = class;
    return block + 1;
}

__attribute__((export_name("free"))) void free(void *memory) {
    if (!memory) return;
    Block *block = (Block *)memory - 1;
    const uint64_t class = block->is.class;
    block->is.next = freed[class];
    freed[class] = block;
}

void *calloc(size_t n, size_t size) {
    if (size && n > SIZE_MAX / size) return NULL;
    void *memory = malloc(n * size);
    return memory ? memset(memory, 0, n * size) : NULL;
}

void *realloc(void *memory, size_t size) {
    void *moved = malloc(size);
    if (!memory || !moved) return moved;
    const size_t had = (size_t)1 << ((Block *)memory - 1)->is.class;
    memcpy(moved, memory, had < size ? had : size);
    free(memory);
    return moved;
}

/* ---- memory and text, as ISO C has them; the loops must not become calls of themselves */
#define PLAIN __attribute__((no_builtin))

PLAIN void *memset(void *to, int value, size_t n) {
    for (unsigned char *c = to; n; n--) *c++ = (unsigned char)value;
    return to;
}

PLAIN void *memcpy(void *restrict to, const void *restrict from, size_t n) {
    unsigned char *t = to;
    for (const unsigned char *f = from; n; n--) *t++ = *f++;
    return to;
}

PLAIN void *memmove(void *to, const void *from, size_t n) {
    unsigned char *t = to;
    const unsigned char *f = from;
    if (t < f) return memcpy(to, from, n);
    while (n--) t[n] = f[n];
    return to;
}

PLAIN int memcmp(const void *a, const void *b, size_t n) {
    const unsigned char *x = a, *y = b;
    for (; n; n--, x++, y++)
        if (*x != *y) return *x - *y;
    return 0;
}

PLAIN size_t strlen(const char *text) {
    size_t n = 0;
    while (text[n]) n++;
    return n;
}

int strncmp(const char *a, const char *b, size_t n) {
    for (; n; n--, a++, b++)
        if (*a != *b || !*a) return (unsigned char)*a - (unsigned char)*b;
    return 0;
}

int strcmp(const char *a, const char *b) { return strncmp(a, b, SIZE_MAX); }

char *strcpy(char *restrict to, const char *restrict from) { return memcpy(to, from, strlen(from) + 1); }

char *strchr(const char *text, int c) {
    for (; *text != (char)c; text++)
        if (!*text) return NULL;
    return (char *)text;
}

int clock_gettime(clockid_t clock, struct timespec *now) {
    (void)clock;
    now->tv_sec = 0, now->tv_nsec = 0;
    return 0;
}

/* ---- messages */

typedef struct {
    char *to;
    size_t n, size;
} Text;

static void put(Text *text, char c) {
    if (text->n + 1 < text->size) text->to[text->n] = c;
    text->n++;
}

static void put_whole(Text *text, uint64_t number) {
    char digits[20];
    int n = 0;
    do digits[n++] = (char)('0' + number % 10), number /= 10;
    while (number);
    while (n) put(text, digits[--n]);
}

/* `digits` significant digits, as %g would have them but for rounding in the last one. */
static void put_real(Text *text, double x, int digits) {
    if (x != x) {
        for (const char *c = "nan"; *c; c++) put(text, *c);
        return;
    }
    if (x < 0) put(text, '-'), x = -x;
    if (x > 1.7976931348623157e308) {
        for (const char *c = "inf"; *c; c++) put(text, *c);
        return;
    }
    int exponent = 0;
    if (x > 0) {
        while (x >= 10) x /= 10, exponent++;
        while (x < 1) x *= 10, exponent--;
    }
    uint64_t scale = 1;
    for (int k = 1; k < digits; k++) scale *= 10;
    uint64_t number = (uint64_t)(x * (double)scale + 0.5);
    if (number >= 10 * scale) number /= 10, exponent++;
    const int plain = exponent >= -5 && exponent < digits;
    while (number && number % 10 == 0 && scale > 1 && !(plain && exponent > 0 && digits <= exponent + 1)) {
        number /= 10, scale /= 10, digits--;
    }
    int before = plain ? exponent : 0; /* digits before the point, less one */
    if (plain && exponent < 0) {
        put(text, '0'), put(text, '.');
        for (int k = -1; k > exponent; k--) put(text, '0');
    }
    for (; scale; scale /= 10) {
        put(text, (char)('0' + number / scale % 10));
        if (before-- == 0 && scale > 1 && !(plain && exponent < 0)) put(text, '.');
    }
    for (; plain && before >= 0; before--) put(text, '0');
    if (!plain) {
        put(text, 'e'), put(text, exponent < 0 ? '-' : '+');
        if (exponent < 10 && exponent > -10) put(text, '0');
        put_whole(text, (uint64_t)(exponent < 0 ? -exponent : exponent));
    }
}

/* Of the formats those that FMUs of the exporter use: %s, %d, %lld, %zu, %u, %g with digits, %%. */
int vsnprintf(char *restrict to, size_t size, const char *restrict format, va_list arguments) {
    Text text = {to, 0, size};
    for (; *format; format++) {
        if (*format != '%') {
            put(&text, *format);
            continue;
        }
        int digits = 6, length = 0;
        format++;
        if (*format == '.')
            for (digits = 0, format++; *format >= '0' && *format <= '9'; format++) digits = 10 * digits + (*format - '0');
        for (; *format == 'l' || *format == 'z'; format++) length += *format == 'l' ? 1 : 0;
        if (*format == 's') {
            for (const char *c = va_arg(arguments, const char *); *c; c++) put(&text, *c);
        } else if (*format == 'd') {
            const int64_t number = length > 1 ? va_arg(arguments, long long) : va_arg(arguments, int);
            if (number < 0) put(&text, '-');
            put_whole(&text, number < 0 ? -(uint64_t)number : (uint64_t)number);
        } else if (*format == 'u') {
            put_whole(&text, length > 1 ? va_arg(arguments, unsigned long long) : va_arg(arguments, unsigned));
        } else if (*format == 'g') {
            put_real(&text, va_arg(arguments, double), digits > 17 ? 17 : digits);
        } else {
            put(&text, *format);
        }
    }
    if (size) to[text.n < size ? text.n : size - 1] = '\0';
    return (int)text.n;
}

int snprintf(char *restrict to, size_t size, const char *restrict format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(to, size, format, arguments);
    va_end(arguments);
    return n;
}

/* ---- what an importer in the page hands to fmi2Instantiate: messages are kept until it asks for them */

static char said[8192];
static size_t said_n;

static void keep(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    va_list arguments;
    va_start(arguments, message);
    if (said_n && said_n + 1 < sizeof said) said[said_n++] = '\n';
    const int n = vsnprintf(said + said_n, sizeof said - said_n, message, arguments);
    va_end(arguments);
    said_n = said_n + (size_t)n < sizeof said ? said_n + (size_t)n : sizeof said - 1;
}

static const struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks = {keep, calloc, free, NULL, NULL};

__attribute__((export_name("web_callbacks"))) const void *web_callbacks(void) { return &callbacks; }

/* All messages since the last call, one a line. */
__attribute__((export_name("web_said"))) const char *web_said(void) {
    said[said_n] = '\0', said_n = 0;
    return said;
}
