#include "experiment/report/page.h"

#include <cjson/cJSON.h>
#include <inttypes.h>

void ll_page_begin(const char *title, FILE *file)
{
    fprintf(file,
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
            "content=\"width=device-width\"><style>\n%s</style><title>",
            ll_report_style);
    ll_page_text(title, file);
    fputs("</title></head><body><main>\n<h1>", file);
    ll_page_text(title, file);
    fputs("</h1>\n", file);
}

void ll_page_views(const char *instead, FILE *file)
{
    fprintf(file,
            "<div id=\"views\"><noscript><p class=\"note\" role=\"note\">Scripts are off: plots and tables "
            "need them. %s</p></noscript></div>\n",
            instead);
}

void ll_page_end(FILE *file)
{
    fprintf(file, "</main>\n<script>\n(() => {\n%s})();\n</script></body></html>\n", ll_report_script);
}

void ll_page_text(const char *text, FILE *file)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", file);
            break;
        case '<':
            fputs("&lt;", file);
            break;
        case '>':
            fputs("&gt;", file);
            break;
        case '"':
            fputs("&quot;", file);
            break;
        default:
            fputc(*text, file);
        }
    }
}

void ll_page_count(int64_t count, FILE *file)
{
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%" PRId64, count);
    for (int i = 0; i < length; i++)
        fprintf(file, "%s%c", i > 0 && (length - i) % 3 == 0 ? "," : "", digits[i]);
}

/* `<` could end the script. */
void ll_page_json(const char *id, const cJSON *json, FILE *file)
{
    char *text = cJSON_PrintUnformatted(json);
    fprintf(file, "<script type=\"application/json\" id=\"%s\">", id);
    for (const char *c = text ? text : "null"; *c; c++)
        if (*c == '<')
            fputs("\\u003c", file);
        else
            fputc(*c, file);
    fputs("</script>\n", file);
    cJSON_free(text);
}

ll_status ll_page_write(const char *path, const char *title, cJSON *data)
{
    FILE *file = fopen(path, "wb");
    if (file) {
        ll_page_begin(title, file);
        ll_page_views("The command below writes the rows as CSV.", file);
        fputs("<p>Repeated by <code>", file);
        ll_page_text(cJSON_GetStringValue(cJSON_GetObjectItem(data, "command")), file);
        fputs("</code>.</p>\n", file);
        ll_page_json("head", data, file);
        ll_page_end(file);
    }
    cJSON_Delete(data);
    bool bad = !file || fflush(file) != 0 || ferror(file);
    if ((file && fclose(file) != 0) || bad)
        return ll_error(LL_IO, "cannot write %.200s", path);
    return ll_ok();
}
