/* Pages in one file: text, numbers, the head with the style of plots and tables. */
#pragma once

#include <stdint.h>
#include <stdio.h>

/* Writes the page up to the heading; `</body></html>` ends it. */
void ll_html_begin(const char *title, FILE *file);

/* The same with more CSS, and within `<main>`, which the page ends. */
void ll_html_begin_styled(const char *title, const char *style, FILE *file);

void ll_html_plot_style(FILE *file); /* CSS of plots */

void ll_html_text(const char *text, FILE *file); /* with & < > " escaped */
void ll_html_count(int64_t count, FILE *file);   /* 12,345 */
