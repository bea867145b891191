#include "daemon/support/access.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROW(name_) .name = #name_, .type = LL_PARAM_TEXT, .offset = offsetof(ll_access_config, name_)

enum { OPERATOR_SHORTEST = 16, CLASS_SHORTEST = 8, LONGEST = 256 }; /* minimum and maximum length of a key */

static const ll_param rows[] = {
    {ROW(operator_key_file), .max = 511,
     .help = "File with the operator's key, which may list and delete everything and close creation. Empty: "
             "$LAGLAB_OPERATOR_KEY, or no operator."},
    {ROW(class_key_file), .max = 511,
     .help = "File with the class key, which permits creating sessions, experiments and searches. Empty: "
             "$LAGLAB_CLASS_KEY, or no class key."},
    {ROW(creation), .max = 15,
     .help = "Who may create: open (every client), class (clients with the class key) or operator. Empty: "
             "class if there is a class key, else open."},
};

const ll_param_table ll_access_table = {.name = "access",
                                        .help = "Permissions.",
                                        .rows = rows,
                                        .count = sizeof rows / sizeof rows[0],
                                        .size = sizeof(ll_access_config)};

const char *const ll_creation_names[] = {
    [LL_CREATION_OPEN] = "open", [LL_CREATION_CLASS] = "class", [LL_CREATION_OPERATOR] = "operator", NULL};

/* ---- keys ---- */

/* Visible ASCII without spaces, as an Authorization header can carry. */
static ll_status take_key(const char *from, char *text, size_t shortest, ll_key_hash *hash)
{
    size_t length = strcspn(text, "\r\n");
    if (text[length + strspn(text + length, "\r\n")] != '\0')
        return ll_error(LL_BAD_INPUT, "key file %.200s: must have one line, the key", from);
    text[length] = '\0';
    for (size_t i = 0; i < length; i++) {
        if (text[i] <= ' ' || text[i] > '~')
            return ll_error(LL_BAD_INPUT, "key of %.200s: must be visible ASCII without spaces", from);
    }
    if (length < shortest || length > LONGEST)
        return ll_error(LL_BAD_INPUT, "key of %.200s: must have %zu to %d characters; got %zu", from,
                        shortest, LONGEST, length);
    return ll_key_hash_make(text, hash) ? ll_ok()
                                        : ll_error(LL_NO_MEMORY, "Random numbers for keys not available.");
}

static ll_status read_key(const char *path, const char *variable, size_t shortest, ll_key_hash *hash,
                          bool *there)
{
    char text[LONGEST + 8];
    const char *value = getenv(variable);
    *there = path[0] != '\0' || (value != NULL && value[0] != '\0');
    if (!*there)
        return ll_ok();
    if (path[0] == '\0') {
        snprintf(text, sizeof text, "%s", value);
        unsetenv(variable); /* so that child processes do not inherit it */
        return take_key(variable, text, shortest, hash);
    }
    FILE *file = fopen(path, "rbe");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[size] = '\0';
    ll_status status = file ? take_key(path, text, shortest, hash)
                            : ll_error(LL_BAD_INPUT, "Cannot read key file %.200s.", path);
    explicit_bzero(text, sizeof text);
    return status;
}

ll_status ll_access_open(const ll_access_config *config, ll_access *access)
{
    memset(access, 0, sizeof *access);
    ll_status status = read_key(config->operator_key_file, "LAGLAB_OPERATOR_KEY", OPERATOR_SHORTEST,
                                &access->operator_key, &access->has_operator);
    LL_THEN(status, read_key(config->class_key_file, "LAGLAB_CLASS_KEY", CLASS_SHORTEST, &access->class_key,
                             &access->has_class));
    if (ll_failed(&status))
        return status;
    if (config->creation[0] == '\0') {
        atomic_store(&access->creation, access->has_class ? LL_CREATION_CLASS : LL_CREATION_OPEN);
        return status;
    }
    return ll_access_set_creation(access, config->creation);
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
            ll_key_matches(&access->class_key, key, length));
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
