/* The files of the page: one folder, read-only, without hidden files. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "daemon/http/internal.h"
#include "daemon/support/gzip.h"
#include "daemon/support/keys.h"

static const char *type_of(const char *path)
{
    static const struct {
        const char *suffix, *type;
    } types[] = {{".html", "text/html; charset=utf-8"},
                 {".js", "text/javascript; charset=utf-8"},
                 {".mjs", "text/javascript; charset=utf-8"},
                 {".css", "text/css; charset=utf-8"},
                 {".json", "application/json"},
                 {".map", "application/json"},
                 {".svg", "image/svg+xml"},
                 {".png", "image/png"},
                 {".jpg", "image/jpeg"},
                 {".ico", "image/x-icon"},
                 {".webp", "image/webp"},
                 {".woff2", "font/woff2"},
                 {".txt", "text/plain; charset=utf-8"},
                 {".md", "text/plain; charset=utf-8"},
                 {".csv", "text/csv; charset=utf-8"},
                 {".yaml", "application/yaml"},
                 {".wasm", "application/wasm"},
                 {".webmanifest", "application/manifest+json"}};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot != NULL && i < sizeof types / sizeof *types; i++) {
        if (strcasecmp(dot, types[i].suffix) == 0) {
            return types[i].type;
        }
    }
    return "application/octet-stream";
}

/* Every segment has a name that does not begin with a dot: no `..`, no hidden files, no empty segments. */
static bool is_safe(const char *path)
{
    if (*path != '/' || strlen(path) > 300 || strchr(path, '\\') != NULL) {
        return false;
    }
    for (const char *at = path; *at != '\0'; at++) {
        if (*at == '/' && (at[1] == '.' || at[1] == '/')) {
            return false;
        }
        if ((unsigned char)*at < ' ') {
            return false;
        }
    }
    return true;
}

/* `/K7QF`, as it stands on the board of a class: to the page, which joins it. Whether there is such a class
 * is not looked up here, where nothing would limit guessing. */
static bool answer_code(http_exchange *exchange)
{
    char code[LL_CODE_LENGTH + 1], to[32];
    const char *path = exchange->path;
    if (!ll_code_read(path + 1, code)) {
        return false;
    }
    snprintf(to, sizeof to, "/#class=%s", code);
    exchange->response.status = 302;
    ll_http_set_header(&exchange->response, "Location", to);
    ll_http_set_header(&exchange->response, "Cache-Control", "no-cache");
    return true;
}

/* A regular file; -1 where there is none. */
static int open_file(const char *name, struct stat *status)
{
    int fd = open(name, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (fd >= 0 && (fstat(fd, status) != 0 || !S_ISREG(status->st_mode))) {
        close(fd);
        return -1;
    }
    return fd;
}

/* Whether `a` was changed before `b`. */
static bool is_older(const struct stat *a, const struct stat *b)
{
    return a->st_mtim.tv_sec != b->st_mtim.tv_sec ? a->st_mtim.tv_sec < b->st_mtim.tv_sec
                                                  : a->st_mtim.tv_nsec < b->st_mtim.tv_nsec;
}

/* The build compresses the page once, as `NAME.gz` next to each file: replaces `fd` by it where the client
 * takes it; whether it did. A file that was changed later is sent as it is. */
static bool take_compressed(http_exchange *exchange, const char *name, int *fd, struct stat *status)
{
    char small[1100];
    struct stat found;
    ll_http_response *response = &exchange->response;
    if (!ll_gzip_compresses(response->type)) {
        return false;
    }
    ll_http_set_header(response, "Vary", "Accept-Encoding");
    if (!ll_http_takes_gzip(&exchange->request)) {
        return false;
    }
    snprintf(small, sizeof small, "%s.gz", name);
    int compressed = open_file(small, &found);
    if (compressed >= 0 && is_older(&found, status)) {
        close(compressed);
        return false;
    }
    if (compressed < 0) {
        return false;
    }
    close(*fd);
    *fd = compressed;
    *status = found;
    return true;
}

void ll_http_file(http_exchange *exchange)
{
    const char *path = exchange->path;
    const char *www = exchange->http->config.www;
    ll_http_response *response = &exchange->response;
    char name[1024], tag[64];
    struct stat status;
    int fd = -1;
    size_t length = strlen(path);
    if (*www != '\0' && is_safe(path)) {
        snprintf(name, sizeof name, "%s%s%s", www, path, path[length - 1] == '/' ? "index.html" : "");
        fd = open_file(name, &status);
    }
    if (fd < 0) {
        if (*www != '\0' && answer_code(exchange)) {
            return;
        }
        ll_http_refuse(exchange, 404, LL_NOT_FOUND, "", "path not found");
        return;
    }
    snprintf(response->type, sizeof response->type, "%s", type_of(path[length - 1] == '/' ? ".html" : path));
    bool compressed = take_compressed(exchange, name, &fd, &status);
    snprintf(tag, sizeof tag, "\"%llx-%llx-%lx\"", (unsigned long long)status.st_size,
             (unsigned long long)status.st_mtim.tv_sec, (unsigned long)status.st_mtim.tv_nsec);
    ll_http_set_header(response, "ETag", tag);
    ll_http_set_header(response, "Cache-Control", "no-cache"); /* revalidated each time, mostly with a 304 */
    if (ll_http_matches_tag(ll_http_header(&exchange->request, "If-None-Match"), tag)) {
        close(fd);
        response->status = 304;
        response->type[0] = '\0';
        return;
    }
    if (compressed) {
        ll_http_set_header(response, "Content-Encoding", "gzip");
    }
    exchange->file = fd;
    exchange->file_size = (uint64_t)status.st_size;
}
