/* FMUs that are carried among the resources: where they lie, and how their libraries are loaded. */

#include <stdlib.h>
#include <string.h>

#include "system.h"

#ifdef CARRIES

#ifdef _WIN32
#define SEPARATOR "\\"
#define SUFFIX ".dll"
#define FOLDER_2 "win64"
#define FOLDER_3 "x86_64-windows"
static void *open_library(const char *path) { return (void *)LoadLibraryExA(path, NULL, LOAD_WITH_ALTERED_SEARCH_PATH); }
static void close_library(void *library) { FreeLibrary((HMODULE)library); }
static void *symbol(void *library, const char *name) { return (void *)(intptr_t)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
#define SEPARATOR "/"
#if defined __aarch64__
#define MACHINE "aarch64"
#else
#define MACHINE "x86_64"
#endif
#ifdef __APPLE__
#define SUFFIX ".dylib"
#define FOLDER_2 "darwin64"
#define FOLDER_3 MACHINE "-darwin"
#else
#define SUFFIX ".so"
#define FOLDER_3 MACHINE "-linux"
#if defined __aarch64__
#define FOLDER_2 FOLDER_3
#else
#define FOLDER_2 "linux64"
#endif
#endif
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void close_library(void *library) { dlclose(library); }
static void *symbol(void *library, const char *name) { return dlsym(library, name); }
#endif

static int hexadecimal(char c) {
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *place = c ? strchr(digits, c) : NULL;
    return place ? (int)(place - digits) % 16 : -1;
}

/* The path of a folder that is given as a file URI (FMI 2.0) or as a path (FMI 3.0), without a separator at its end. */
static char *path_of(const char *given) {
    const int uri = strncmp(given, "file:", 5) == 0;
    const char *from = uri ? given + 5 : given;
    if (uri && strncmp(from, "//", 2) == 0) { /* an authority, mostly empty, stands before the path */
        from += 2;
        while (*from && *from != '/') from++;
    }
#ifdef _WIN32
    if (uri && from[0] == '/' && from[1] && from[2] == ':') from++;
#endif
    char *path = joined_text(from, "", ""), *to = path;
    if (!path) return NULL;
    for (const char *c = path; *c; c++) {
        if (uri && *c == '%' && hexadecimal(c[1]) >= 0 && hexadecimal(c[2]) >= 0) {
            *to++ = (char)(16 * hexadecimal(c[1]) + hexadecimal(c[2]));
            c += 2;
        } else {
            *to++ = *c;
        }
    }
    *to = '\0';
    while (to > path + 1 && (to[-1] == '/' || to[-1] == '\\')) *--to = '\0';
    return path;
}

/* The file URI of a path. */
static char *uri_of(const char *path) {
    static const char digits[] = "0123456789ABCDEF", plain[] = "-._~/:";
    char *uri = malloc(3 * strlen(path) + 9), *to = uri;
    if (!uri) return NULL;
    to += strlen(strcpy(to, path[0] == '/' ? "file://" : "file:///"));
    for (const unsigned char *c = (const unsigned char *)path; *c; c++) {
        const int letter = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9');
        if (letter || strchr(plain, *c)) *to++ = (char)*c;
        else if (*c == '\\') *to++ = '/';
        else *to++ = '%', *to++ = digits[*c >> 4], *to++ = digits[*c & 15];
    }
    *to = '\0';
    return uri;
}

/* Loads the library of component `c`, and finds where its resources are. */
static int load(System *m, Component *c) {
    const int version = c->data->version;
    char *root = path_of(m->resources), *folder = root ? joined_text(root, SEPARATOR, c->data->folder) : NULL;
    char *binaries = folder ? joined_text(folder, SEPARATOR "binaries" SEPARATOR, version == 3 ? FOLDER_3 : FOLDER_2) : NULL;
    char *stem = binaries ? joined_text(binaries, SEPARATOR, c->data->library) : NULL;
    char *path = stem ? joined_text(stem, SUFFIX, "") : NULL;
    char *resources = folder ? joined_text(folder, SEPARATOR "resources", version == 3 ? SEPARATOR : "") : NULL;
    if (path && resources) {
        c->library = open_library(path);
        c->resources = version == 3 ? joined_text(resources, "", "") : uri_of(resources);
        if (!c->library) tell(m, ERROR, LOG_ERROR, "component %s: its library %s cannot be loaded", c->data->name, path);
    }
    free(root), free(folder), free(binaries), free(stem), free(path), free(resources);
    return c->library && c->resources;
}

/* The functions of a loaded library, NULL where it lacks one; which it must have is asked once. */
static int find_functions(System *m, Component *c) {
#define FIND_2(p, of) *(void **)&c->loaded.of = symbol(c->library, "fmi2" #of);
    FUNCTIONS_2(FIND_2, )
    const Functions2 *f = &c->loaded;
    const int basic = f->Instantiate && f->FreeInstance && f->SetupExperiment && f->EnterInitializationMode &&
                      f->ExitInitializationMode && f->Terminate && f->GetReal && f->SetReal && f->DoStep;
    const int states = f->GetFMUstate && f->SetFMUstate && f->FreeFMUstate;
    const int written = f->SerializedFMUstateSize && f->SerializeFMUstate && f->DeSerializeFMUstate;
    if (!basic || (c->data->restores && !states) || (ALL_SERIALIZE && !written) ||
        (c->data->degree > 0 && !f->SetRealInputDerivatives)) {
        tell(m, ERROR, LOG_ERROR, "component %s: its library lacks a function of FMI 2.0", c->data->name);
        return 0;
    }
    c->f = f;
    return 1;
}

#endif
