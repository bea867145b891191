/* Pages in one file: head, style, texts, data as JSON, and the script of www/report, which draws the data.
 * They need no other file, nor a network. */
#pragma once

#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

struct cJSON;

extern const char ll_report_script[], ll_report_style[]; /* made of www/report by the build */

void ll_page_begin(const char *title, FILE *file); /* up to the heading */
/* Where the script draws; without scripts `instead` is there, as HTML: how to get the data. */
void ll_page_views(const char *instead, FILE *file);
void ll_page_end(FILE *file);

void ll_page_text(const char *text, FILE *file);                         /* with & < > " escaped */
void ll_page_count(int64_t count, FILE *file);                           /* 12,345 */
void ll_page_json(const char *id, const struct cJSON *json, FILE *file); /* data for the script */

/* A page that has only what the script draws of `data`: its "kind" names the view, its "command" repeats the
 * measurement. Deletes `data`. */
ll_status ll_page_write(const char *path, const char *title, struct cJSON *data);
