/* Start Python, import the slave and call its methods. See front.h. */

#include "front.h"

#include <dlfcn.h>
#include <link.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- functions of Python's C interface, fetched by name --------------------------------------------------------- */

typedef void PyObject;

#define PYTHON(F)                                                                                       \
    F(int, Py_IsInitialized, (void)) F(void, Py_InitializeEx, (int)) F(PyObject *, PyEval_SaveThread, (void))            \
    F(int, PyGILState_Ensure, (void)) F(void, PyGILState_Release, (int))                                                 \
    F(void, Py_SetProgramName, (const wchar_t *)) F(wchar_t *, Py_DecodeLocale, (const char *, size_t *))                \
    F(PyObject *, PyRun_String, (const char *, int, PyObject *, PyObject *)) F(PyObject *, PyDict_New, (void))           \
    F(int, PyDict_SetItemString, (PyObject *, const char *, PyObject *))                                                 \
    F(PyObject *, Py_BuildValue, (const char *, ...))                                                                    \
    F(PyObject *, Py_VaBuildValue, (const char *, va_list))                                                              \
    F(PyObject *, PyObject_GetAttrString, (PyObject *, const char *))                                                    \
    F(PyObject *, PyObject_CallObject, (PyObject *, PyObject *)) F(PyObject *, PyImport_ImportModule, (const char *))    \
    F(long, PyLong_AsLong, (PyObject *)) F(const char *, PyUnicode_AsUTF8, (PyObject *))                                 \
    F(PyObject *, PyUnicode_FromString, (const char *)) F(PyObject *, PyList_New, (ptrdiff_t))                           \
    F(int, PyList_SetItem, (PyObject *, ptrdiff_t, PyObject *)) F(ptrdiff_t, PyList_Size, (PyObject *))                  \
    F(PyObject *, PyList_GetItem, (PyObject *, ptrdiff_t)) F(PyObject *, PyTuple_GetItem, (PyObject *, ptrdiff_t))       \
    F(PyObject *, PyBytes_FromStringAndSize, (const char *, ptrdiff_t))                                                  \
    F(int, PyBytes_AsStringAndSize, (PyObject *, char **, ptrdiff_t *))                                                  \
    F(void, PyErr_Fetch, (PyObject **, PyObject **, PyObject **)) F(PyObject *, PyObject_Str, (PyObject *))              \
    F(void, PyErr_NormalizeException, (PyObject **, PyObject **, PyObject **)) F(void, PyErr_Clear, (void))              \
    F(void, Py_DecRef, (PyObject *))

#define MEMBER(result, name, arguments) result (*name) arguments;
static struct { PYTHON(MEMBER) } py;
static pthread_mutex_t starting = PTHREAD_MUTEX_INITIALIZER;

/* Return the name of the first function that `library` lacks, NULL if it has all. */
static const char *fetch(void *library)
{
#define FETCH(result, name, arguments) if (!(*(void **)&py.name = dlsym(library, #name))) return #name;
    PYTHON(FETCH)
    return NULL;
}

/* ---- search for Python ------------------------------------------------------------------------------------------ */

/* Make a libpython that the host loaded privately visible to extension modules. */
static int promote(struct dl_phdr_info *info, size_t size, void *found)
{
    (void)size;
    const char *file = strrchr(info->dlpi_name, '/');
    if (!file || strncmp(file, "/libpython3.", 12))
        return 0;
    *(void **)found = dlopen(info->dlpi_name, RTLD_NOLOAD | RTLD_NOW | RTLD_GLOBAL);
    return 1;
}

static void *python_in_process(void)
{
    void *library = NULL, *everything = dlopen(NULL, RTLD_NOW);
    if (dlsym(everything, "Py_IsInitialized"))
        return everything;
    dl_iterate_phdr(promote, &library);
    return library;
}

/* Append `text` in single quotes for a shell. */
static void quote(char *command, size_t size, const char *text)
{
    size_t end = strlen(command);
    for (const char *c = text; *c && end + 8 < size; c++)
        end += (size_t)sprintf(command + end, "%s", *c == '\'' ? "'\\''" : (char[]){*c, 0});
}

/* Ask an interpreter for its shared library: "library PATH", or a sentence on what it lacks. */
static void probe(const char *interpreter, const char *resources, char *answer, int size)
{
    char command[16384] = "'";
    quote(command, sizeof command - 64, interpreter);
    strcat(command, "' '");
    quote(command, sizeof command - 64, resources);
    strcat(command, "/requirements.py' 2>/dev/null");
    FILE *stream = popen(command, "r");
    answer[0] = 0;
    if (stream) {
        front_first_line(stream, answer, size);
        pclose(stream);
    }
    if (!answer[0])
        snprintf(answer, (size_t)size, "does not run");
}

/* Path of the Python that last built an FMU: python.txt in the user's cache. */
static void record_of_python(char *path, size_t size)
{
    const char *own = getenv("PISTON_COSIM_CACHE"), *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (own && own[0])
        snprintf(path, size, "%s/python.txt", own);
    else if (cache && cache[0])
        snprintf(path, size, "%s/piston-cosim/python.txt", cache);
    else
        snprintf(path, size, "%s/.cache/piston-cosim/python.txt", home ? home : "");
}

/* Start the first suitable Python: $PISTON_COSIM_PYTHON, that of $VIRTUAL_ENV, the one that last built an FMU on this
   machine, python3. */
static void *start_first_python(Instance *I)
{
    char recorded[4096] = "", environment[8192] = "", path[8192], answer[8192], refusals[16384] = "";
    record_of_python(path, sizeof path);
    FILE *file = fopen(path, "r");
    if (file) {
        front_first_line(file, recorded, sizeof recorded);
        fclose(file);
    }
    if (getenv("VIRTUAL_ENV"))
        snprintf(environment, sizeof environment, "%s/bin/python", getenv("VIRTUAL_ENV"));
    const char *candidates[] = {getenv("PISTON_COSIM_PYTHON"), environment, recorded, "python3"};
    for (int k = 0; k < 4; k++) {
        if (!candidates[k] || !candidates[k][0])
            continue;
        probe(candidates[k], I->resources, answer, sizeof answer);
        char *library = answer + 8, *executable = strchr(answer, '\t');
        if (strncmp(answer, "library ", 8) || !executable) {
            size_t end = strlen(refusals);
            snprintf(refusals + end, sizeof refusals - end, "\n  %.2000s: %.3000s", candidates[k], answer);
            continue;
        }
        *executable++ = 0;
        void *handle = dlopen(library, RTLD_NOW | RTLD_GLOBAL);
        const char *lacking = handle ? fetch(handle) : dlerror();
        if (lacking) {
            front_log(I, ERROR, "%s: %s", library, lacking);
            return NULL;
        }
        py.Py_SetProgramName(py.Py_DecodeLocale(executable, NULL));   /* gives Python its venv */
        py.Py_InitializeEx(0);                                        /* 0: keep the host's signal handlers */
        py.PyEval_SaveThread();
        return handle;
    }
    front_log(I, ERROR, "this FMU needs a Python; set PISTON_COSIM_PYTHON to one, or mend one of these:%s", refusals);
    return NULL;
}

/* Start Python without PYTHONHOME, which belongs to the host's Python and would break the start of another one. */
static void *start_python(Instance *I)
{
    char *home = getenv("PYTHONHOME") ? strdup(getenv("PYTHONHOME")) : NULL;
    unsetenv("PYTHONHOME");
    void *handle = start_first_python(I);
    if (home)
        setenv("PYTHONHOME", home, 1);
    free(home);
    return handle;
}

static int have_python(Instance *I)
{
    pthread_mutex_lock(&starting);
    int ready = py.Py_IsInitialized && py.Py_IsInitialized();
    void *library = ready ? NULL : python_in_process();
    if (!ready && library) {
        const char *lacking = fetch(library);
        if (lacking)
            front_log(I, ERROR, "the Python in this process has no %s", lacking);
        ready = !lacking && py.Py_IsInitialized();
    }
    if (!ready && !library)
        ready = start_python(I) != NULL;
    pthread_mutex_unlock(&starting);
    return ready;
}

/* ---- calls of the slave (the interpreter is held) --------------------------------------------------------------- */

/* Log the current exception and clear it. */
static int raised(Instance *I, const char *where)
{
    PyObject *type = NULL, *value = NULL, *trace = NULL;
    py.PyErr_Fetch(&type, &value, &trace);
    py.PyErr_NormalizeException(&type, &value, &trace);
    PyObject *text = value ? py.PyObject_Str(value) : NULL;
    const char *said = text ? py.PyUnicode_AsUTF8(text) : NULL;
    front_log(I, ERROR, "%s: %s", where, said ? said : "unknown exception");
    py.PyErr_Clear();
    PyObject *owned[] = {type, value, trace, text};
    for (int k = 0; k < 4; k++)
        py.Py_DecRef(owned[k]);
    return ERROR;
}

static PyObject *invoke(PyObject *owner, const char *method, PyObject *arguments)
{
    PyObject *function = arguments ? py.PyObject_GetAttrString(owner, method) : NULL;
    PyObject *result = function ? py.PyObject_CallObject(function, arguments) : NULL;
    py.Py_DecRef(function);
    py.Py_DecRef(arguments);
    return result;
}

/* Send the slave's log messages; return the status of the last call. */
static int verdict(Instance *I)
{
    PyObject *verdict = invoke(I->slave, "verdict", py.Py_BuildValue("()"));
    if (!verdict)
        return raised(I, "verdict");
    long status = py.PyLong_AsLong(py.PyTuple_GetItem(verdict, 0));
    PyObject *messages = py.PyTuple_GetItem(verdict, 1);
    for (ptrdiff_t k = 0; k < py.PyList_Size(messages); k++) {
        PyObject *message = py.PyList_GetItem(messages, k);
        long severity = py.PyLong_AsLong(py.PyTuple_GetItem(message, 0));
        const char *text = py.PyUnicode_AsUTF8(py.PyTuple_GetItem(message, 2));
        if (text && (I->logging || severity != OK))
            I->send(I, (int)severity, py.PyUnicode_AsUTF8(py.PyTuple_GetItem(message, 1)), text);
    }
    py.PyErr_Clear();
    py.Py_DecRef(verdict);
    return (int)status;
}

/* Call a method; return its result, or NULL after logging its error. */
static PyObject *ask(Instance *I, const char *method, PyObject *arguments, int *status)
{
    PyObject *result = invoke(I->slave, method, arguments);
    if (!result)
        raised(I, method);
    int judged = verdict(I);
    *status = result ? judged : ERROR;
    return result;
}

/* Call a method without a result, arguments as for Py_BuildValue; return a status. */
static int call(Instance *I, const char *method, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int held = py.PyGILState_Ensure();
    int status;
    py.Py_DecRef(ask(I, method, py.Py_VaBuildValue(format, list), &status));
    py.PyGILState_Release(held);
    va_end(list);
    return status;
}

int slave_step(Instance *I, double time, double step) { return call(I, "do_step", "(dd)", time, step); }

int slave_initialise(Instance *I, int enters)
{
    return call(I, enters ? "enter_initialization_mode" : "exit_initialization_mode", "()");
}

int slave_terminate(Instance *I) { return call(I, "terminate", "()"); }
int slave_products(Instance *I) { return call(I, "update_products", "()"); }
int slave_show(Instance *I) { return call(I, "show_start", "()"); }

/* ---- instances -------------------------------------------------------------------------------------------------- */

/* Copy `count` records of `width` numbers and advance the cursor. */
static void *take(const int64_t **cursor, int64_t count, int64_t width)
{
    size_t size = (size_t)(count * width) * sizeof(int64_t);
    void *copy = malloc(size + 1);
    memcpy(copy, *cursor, size);
    *cursor += count * width;
    return copy;
}

static void forget_layout(Instance *I)
{
    free(I->course);
    free(I->seed);
    free(I->product);
    free(I->variable);
    I->course = I->seed = I->product = NULL;
    I->variable = NULL;
}

/* Read the addresses of the slave's numbers. */
static int read_layout(Instance *I)
{
    char *bytes;
    ptrdiff_t size;
    int status;
    PyObject *layout = ask(I, "layout", py.Py_BuildValue("()"), &status);
    if (status != OK || py.PyBytes_AsStringAndSize(layout, &bytes, &size))
        return ERROR;
    const int64_t *cursor = (const int64_t *)bytes;
    I->real = (double *)(intptr_t)cursor[0];
    I->integer = (int64_t *)(intptr_t)cursor[1];
    I->reals = cursor[2], I->integers = cursor[3], I->strings = cursor[4];
    I->first_integer = cursor[5], I->first_string = cursor[6];
    I->courses = cursor[7], I->seeds = cursor[8], I->products = cursor[9], I->variables = cursor[10];
    cursor += 11;
    forget_layout(I);
    I->course = take(&cursor, I->courses, 3);
    I->seed = take(&cursor, I->seeds, 3);
    I->product = take(&cursor, I->products, 3);
    I->variable = take(&cursor, I->variables, 4);
    py.Py_DecRef(layout);
    return OK;
}

static const char IMPORT[] =
    "import sys, importlib\n"
    "sys.path.insert(0, resources)\n"
    "try:\n"
    "    name = open(resources + '/slavemodule.txt', encoding='utf-8').readline().strip()\n"
    "    entry = importlib.import_module(name)\n"
    "finally:\n"
    "    sys.path.remove(resources)\n"
    "slave = entry.Entry(instance_name=instance, resources=resources)\n";

static int import_slave(Instance *I)
{
    PyObject *scope = py.PyDict_New(), *done = NULL;
    PyObject *resources = py.PyUnicode_FromString(I->resources), *name = py.PyUnicode_FromString(I->name);
    if (resources && name) {
        py.PyDict_SetItemString(scope, "resources", resources);
        py.PyDict_SetItemString(scope, "instance", name);
        done = py.PyRun_String(IMPORT, 257 /* Py_file_input */, scope, scope);
    }
    int status = done ? OK : raised(I, "instantiate");
    if (status == OK) {
        py.Py_DecRef(I->slave);
        I->slave = invoke(scope, "__getitem__", py.Py_BuildValue("(s)", "slave"));
        status = read_layout(I);
    }
    PyObject *owned[] = {scope, resources, name, done};
    for (int k = 0; k < 4; k++)
        py.Py_DecRef(owned[k]);
    return status;
}

static int with_python(Instance *I)
{
    int held = py.PyGILState_Ensure();
    int status = import_slave(I);
    py.PyGILState_Release(held);
    return status;
}

int slave_create(Instance *I) { return have_python(I) ? with_python(I) : ERROR; }
int slave_reset(Instance *I) { return with_python(I); }

void slave_free(Instance *I)
{
    if (py.Py_IsInitialized && py.Py_IsInitialized()) {
        int held = py.PyGILState_Ensure();
        py.Py_DecRef(I->slave);
        py.Py_DecRef(I->text);
        py.PyGILState_Release(held);
    }
    forget_layout(I);
}

/* ---- texts and states ------------------------------------------------------------------------------------------- */

int slave_set_text(Instance *I, Reference reference, const char *text)
{
    return call(I, "set_string", "([I][s])", reference, text);
}

int slave_get_texts(Instance *I, const Reference *reference, size_t count, const char **texts)
{
    int status, held = py.PyGILState_Ensure();
    PyObject *list = py.PyList_New((ptrdiff_t)count);
    for (size_t k = 0; k < count; k++)
        py.PyList_SetItem(list, (ptrdiff_t)k, py.Py_BuildValue("I", reference[k]));
    PyObject *result = ask(I, "get_string", py.Py_BuildValue("(N)", list), &status);
    py.Py_DecRef(I->text);
    I->text = result;
    for (size_t k = 0; result && k < count; k++)
        texts[k] = py.PyUnicode_AsUTF8(py.PyList_GetItem(result, (ptrdiff_t)k));
    py.PyGILState_Release(held);
    return status;
}

int slave_get_state(Instance *I, void **state)
{
    slave_free_state(*state);
    int status, held = py.PyGILState_Ensure();
    *state = ask(I, "_get_fmu_state", py.Py_BuildValue("()"), &status);
    py.PyGILState_Release(held);
    return status;
}

int slave_set_state(Instance *I, void *state)
{
    return call(I, "_set_fmu_state", "(O)", state);
}

void slave_free_state(void *state)
{
    int held = py.PyGILState_Ensure();
    py.Py_DecRef(state);
    py.PyGILState_Release(held);
}

int slave_state_to_bytes(Instance *I, void *state, char *bytes, size_t *size)
{
    char *data;
    ptrdiff_t length;
    int status, held = py.PyGILState_Ensure();
    PyObject *result = ask(I, "_fmu_state_to_bytes", py.Py_BuildValue("(O)", state), &status);
    if (status == OK && py.PyBytes_AsStringAndSize(result, &data, &length))
        status = ERROR;
    if (status == OK && bytes)
        memcpy(bytes, data, (size_t)length);
    if (status == OK && !bytes)
        *size = (size_t)length;
    py.Py_DecRef(result);
    py.PyGILState_Release(held);
    return status;
}

int slave_state_from_bytes(Instance *I, const char *bytes, size_t size, void **state)
{
    int status, held = py.PyGILState_Ensure();
    PyObject *data = py.PyBytes_FromStringAndSize(bytes, (ptrdiff_t)size);
    *state = ask(I, "_fmu_state_from_bytes", py.Py_BuildValue("(N)", data), &status);
    py.PyGILState_Release(held);
    return status;
}
