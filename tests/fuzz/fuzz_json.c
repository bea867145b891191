/* Any JSON: accepted documents are objects, arrays or scalars that a second, stricter reader accepts too or
 * rejects for a known reason; they have no NUL, respect the nesting limit, and print to text that parses to
 * the same. */
#include "check.h"

#include "session/scenario.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int depth_of(const cJSON *json)
{
    int deepest = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, json)
    {
        int depth = depth_of(item);
        deepest = depth > deepest ? depth : deepest;
    }
    return cJSON_IsObject(json) || cJSON_IsArray(json) ? deepest + 1 : deepest;
}

/* RFC 8259 without numbers and strings: matching brackets outside of quotes. */
static bool is_balanced(const char *text, size_t size)
{
    char open[LL_JSON_DEPTH + 1];
    int depth = 0;
    for (size_t i = 0; i < size; i++) {
        char c = text[i];
        if (c == '"') {
            for (i++; i < size && text[i] != '"'; i++)
                i += text[i] == '\\';
            if (i >= size)
                return false;
        } else if (c == '{' || c == '[') {
            if (depth == LL_JSON_DEPTH)
                return false;
            open[depth++] = c;
        } else if (c == '}' || c == ']') {
            if (depth == 0 || open[--depth] != (c == '}' ? '{' : '['))
                return false;
        }
    }
    return depth == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size > 0 ? size : 1); /* exact allocation, without a NUL at the end */
    cJSON *json = NULL, *again = NULL;
    FUZZ_CHECK(text != NULL);
    memcpy(text, data, size);
    ll_status status = ll_json_parse(text, size, &json);
    FUZZ_CHECK(fuzz_failed(&status) == (json == NULL));
    if (json != NULL) {
        FUZZ_CHECK(memchr(text, '\0', size) == NULL);
        FUZZ_CHECK(is_balanced(text, size));
        FUZZ_CHECK(depth_of(json) <= LL_JSON_DEPTH);
        char *once = cJSON_PrintUnformatted(json);
        FUZZ_CHECK(once != NULL);
        status = ll_json_parse(once, strlen(once), &again);
        FUZZ_CHECK(!fuzz_failed(&status));
        char *twice = fuzz_print(again);
        FUZZ_CHECK(strcmp(once, twice) == 0);
        cJSON_free(once);
        cJSON_free(twice);
    }
    cJSON_Delete(json);
    free(text);
    return 0;
}
