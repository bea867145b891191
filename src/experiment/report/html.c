#include "experiment/report/html.h"

#include <inttypes.h>

static const char head[] =
    "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
    "content=\"width=device-width\"><style>\n"
    "body{font:15px/1.45 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b1f24;"
    "background:#fff}h1{font-size:1.6rem;margin-bottom:.2rem}h2{font-size:1.2rem;margin-top:2rem}\n"
    ".multiples{display:grid;grid-template-columns:repeat(auto-fill,minmax(20rem,1fr));gap:1rem}"
    ".multiples>*{min-width:0}\n"
    ".data{max-height:14rem;overflow:auto;border:1px solid #d8dee4}table{border-collapse:collapse;"
    "font-size:.85rem;font-variant-numeric:tabular-nums}th,td{padding:.15rem .6rem;text-align:right;"
    "border-bottom:1px solid #eaeef2}th{position:sticky;top:0;background:#f6f8fa}td.l{text-align:left}"
    "tr.on td{color:#8a3700;font-weight:600}\n"
    "pre{background:#f6f8fa;padding:.8rem;overflow:auto;font-size:.8rem;white-space:pre-wrap}\n"
    "@media print{body{margin:0;max-width:none}.data{max-height:none;overflow:visible;border:0}"
    "figure{break-inside:avoid-page}th{position:static}pre{white-space:pre-wrap}}\n";

/* Colours of Okabe and Ito that can be distinguished on white; shapes differ too. */
static const char plots[] =
    "figure{margin:1rem 0}figcaption{font-weight:600}svg{max-width:100%;height:auto}svg text{font:12px "
    "system-ui,sans-serif;fill:#1b1f24}.g{stroke:#d8dee4;fill:none}.front{fill:none;stroke:#b34700;"
    "stroke-width:1.5}.ci{stroke:#57606a;stroke-opacity:.4}.s{fill-opacity:.75}.on{fill-opacity:1;"
    "stroke:#b34700;stroke-width:2}\n"
    ".s0{fill:#0072b2;stroke:#0072b2}.s1{fill:#009e73;stroke:#009e73}.s2{fill:#cc79a7;stroke:#cc79a7}"
    ".s3{fill:#c98a00;stroke:#c98a00}.s4{fill:#56b4e9;stroke:#56b4e9}.s5{fill:#7a4fb5;stroke:#7a4fb5}"
    ".s6{fill:#6b6b00;stroke:#6b6b00}.s7{fill:#1b1f24;stroke:#1b1f24}.s{stroke:none}.line{fill:none!"
    "important}"
    ".s.on{stroke:#b34700}.key span{display:inline-block;margin-right:1rem}.key svg{vertical-align:middle}\n"
    ".level{stroke:#57606a;stroke-dasharray:5 3;fill:none}.chosen{fill:none;stroke:#1b1f24;stroke-width:1.5}"
    ".note{font-size:.85rem;margin:.2rem 0}\n";

void ll_html_plot_style(FILE *file)
{
    fputs(plots, file);
}

static void begin(const char *title, const char *style, const char *outer, FILE *file)
{
    fputs(head, file);
    ll_html_plot_style(file);
    fputs(style, file);
    fputs("</style><title>", file);
    ll_html_text(title, file);
    fprintf(file, "</title></head><body>%s\n<h1>", outer);
    ll_html_text(title, file);
    fputs("</h1>\n", file);
}

void ll_html_begin(const char *title, FILE *file)
{
    begin(title, "", "", file);
}

void ll_html_begin_styled(const char *title, const char *style, FILE *file)
{
    begin(title, style, "<main>", file);
}

void ll_html_text(const char *text, FILE *file)
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

void ll_html_count(int64_t count, FILE *file)
{
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%" PRId64, count);
    for (int i = 0; i < length; i++)
        fprintf(file, "%s%c", i > 0 && (length - i) % 3 == 0 ? "," : "", digits[i]);
}
