#include "daemon/support/access.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROW(name_) LL_PARAM_ROW(#name_, TEXT, ll_access_config, name_)

enum { OPERATOR_SHORTEST = 16, LARGEST = 128 << 10 };

static const ll_param rows[] = {
    {ROW(operator_key_file), .max = 511,
     .help = "File with the operator's key, which may list and delete everything and close creation. Empty: "
             "$LAGLAB_OPERATOR_KEY, or no operator."},
    {ROW(class_key_file), .max = 511,
     .help = "File with the class key, which permits creating sessions, experiments and searches; or with a "
             "line for each of several, NAME KEY and its quotas. Empty: $LAGLAB_CLASS_KEY, or no class key."},
    {ROW(creation), .max = 15,
     .help = "Who may create: open (every client), class (clients with a class key) or operator. Empty: "
             "class if there is a class key, else open."},
};

const ll_param_table ll_access_table = {
    .name = "access", .help = "Permissions.", LL_PARAM_ROWS(rows, ll_access_config)};

const char *const ll_creation_names[] = {
    [LL_CREATION_OPEN] = "open", [LL_CREATION_CLASS] = "class", [LL_CREATION_OPERATOR] = "operator", NULL};

/* ---- keys ---- */

static ll_status read_file(const char *path, char **text)
{
    FILE *file = fopen(path, "rbe");
    *text = file ? calloc(1, LARGEST + 1) : NULL;
    size_t size = *text ? fread(*text, 1, LARGEST, file) : 0;
    bool whole = file && size < LARGEST;
    if (file)
        fclose(file);
    if (!*text)
        return ll_error(LL_BAD_INPUT, "Cannot read key file %.200s.", path);
    return whole
               ? ll_ok()
               : ll_error(LL_BAD_INPUT, "key file %.200s: must be smaller than %d KiB", path, LARGEST >> 10);
}

/* What a file of keys, or without one the environment, has. NULL: nothing. The caller frees it, also after an
 * error. */
static ll_status read_keys(const char *path, const char *variable, char **text, const char **from)
{
    const char *value = getenv(variable);
    *from = path[0] ? path : variable;
    *text = NULL;
    if (path[0])
        return read_file(path, text);
    if (!value || !value[0])
        return ll_ok();
    *text = strdup(value);
    unsetenv(variable); /* so that child processes do not inherit it */
    return *text ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: keys");
}

static void forget(char *text, size_t size)
{
    if (text)
        explicit_bzero(text, size);
    free(text);
}

static ll_status read_operator(const char *path, ll_access *access)
{
    char *text;
    const char *from;
    ll_status status = read_keys(path, "LAGLAB_OPERATOR_KEY", &text, &from);
    if (!text)
        return status;
    size_t size = strlen(text), length = strcspn(text, "\r\n");
    if (!ll_failed(&status) && text[length + strspn(text + length, "\r\n")] != '\0')
        status = ll_error(LL_BAD_INPUT, "key file %.200s: must have one line, the key", from);
    text[length] = '\0';
    LL_THEN(status, ll_key_check(from, text, OPERATOR_SHORTEST));
    if (!ll_failed(&status) && !ll_key_hash_make(text, &access->operator_key))
        status = ll_error(LL_NO_MEMORY, "Random numbers for keys not available.");
    access->has_operator = !ll_failed(&status);
    forget(text, size);
    return status;
}

static ll_status read_class(const char *path, ll_access *access)
{
    char *text;
    const char *from;
    ll_status status = read_keys(path, "LAGLAB_CLASS_KEY", &text, &from);
    if (!text)
        return status;
    size_t size = strlen(text);
    LL_THEN(status, ll_class_keys_read(&access->class_keys, from, text));
    access->has_class = !ll_failed(&status);
    forget(text, size);
    return status;
}

ll_status ll_access_open(const ll_access_config *config, ll_access *access)
{
    memset(access, 0, sizeof *access);
    ll_status status = read_operator(config->operator_key_file, access);
    LL_THEN(status, read_class(config->class_key_file, access));
    if (ll_failed(&status))
        return status;
    if (config->creation[0] == '\0') {
        atomic_store(&access->creation, access->has_class ? LL_CREATION_CLASS : LL_CREATION_OPEN);
        return status;
    }
    return ll_access_set_creation(access, config->creation);
}

void ll_access_close(ll_access *access)
{
    ll_class_keys_free(&access->class_keys);
}

/* ---- permissions ---- */

bool ll_access_is_operator(const ll_access *access, const char *key, size_t length)
{
    return access && access->has_operator && ll_key_matches(&access->operator_key, key, length);
}

bool ll_access_may_create(const ll_access *access, const char *key, size_t length)
{
    int creation = access ? atomic_load(&access->creation) : LL_CREATION_OPEN;
    return creation == LL_CREATION_OPEN || ll_access_is_operator(access, key, length) ||
           (creation == LL_CREATION_CLASS && access->has_class &&
            ll_class_keys_find(&access->class_keys, key, length) != NULL);
}

ll_class_key *ll_access_class_key(const ll_access *access, const char *key, size_t length)
{
    ll_class_key *found = access ? ll_class_keys_find(&access->class_keys, key, length) : NULL;
    return found && found->name[0] ? found : NULL;
}

ll_class_key *ll_access_named_key(const ll_access *access, const char *name)
{
    return access ? ll_class_keys_named(&access->class_keys, name) : NULL;
}

ll_status ll_access_set_creation(ll_access *access, const char *name)
{
    int creation = 0;
    while (ll_creation_names[creation] && strcmp(ll_creation_names[creation], name) != 0)
        creation++;
    if (!ll_creation_names[creation])
        return ll_field_error(LL_BAD_INPUT, "creation",
                              "creation: must be one of open, class, operator; got `%.40s`.", name);
    if ((creation == LL_CREATION_CLASS && !access->has_class) ||
        (creation == LL_CREATION_OPERATOR && !access->has_operator))
        return ll_field_error(LL_BAD_INPUT, "creation", "creation: %s requires the %s key", name,
                              creation == LL_CREATION_CLASS ? "class" : "operator's");
    atomic_store(&access->creation, creation);
    return ll_ok();
}
