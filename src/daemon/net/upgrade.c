#include "daemon/net/upgrade.h"

#include <arpa/inet.h>
#include <string.h>
#include <strings.h>

const char *const ll_stream_protocols[LL_STREAM_PROTOCOLS] = {
    [LL_FRAME_BINARY] = "laglab.v2.bin", [LL_FRAME_JSON] = "laglab.v2.json"};

const char *const ll_stream_names[LL_STREAM_KINDS] = {"session", "experiment", "class"};

static bool is_name_character(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

static bool equals(ll_text text, const char *word)
{
    return text.at != NULL && text.size == strlen(word) && strncasecmp(text.at, word, text.size) == 0;
}

static ll_text trim(ll_text text)
{
    while (text.size > 0 && (*text.at == ' ' || *text.at == '\t')) {
        text.at++;
        text.size--;
    }
    while (text.size > 0 && (text.at[text.size - 1] == ' ' || text.at[text.size - 1] == '\t'))
        text.size--;
    return text;
}

/* ---- targets ---- */

const char *ll_target_fault(const char *target)
{
    for (const char *at = target; *at != '\0'; at++)
        if (*at <= ' ' && *at >= 0)
            return "target: must not have spaces and control characters";
    if (strstr(target, "%00") != NULL)
        return "target: must not have a NUL (%00)";
    const char *authority = strstr(target, "://");
    if (target[0] != '/' && authority != NULL &&
        memchr(authority + 3, '%', strcspn(authority + 3, "/?")) != NULL)
        return "target: must not have a % in its host";
    const char *query = strchr(target, '?');
    int arguments = query != NULL;
    for (; query != NULL && *query != '\0'; query++)
        arguments += *query == '&';
    return arguments > LL_ARGUMENTS_MAX ? "query: must have at most 64 arguments" : NULL;
}

/* ---- lists ---- */

/* Takes the first element of a comma separated list; false at its end. */
static bool next_element(ll_text *list, ll_text *element)
{
    while (list->at != NULL && list->size > 0) {
        const char *comma = memchr(list->at, ',', list->size);
        size_t size = comma != NULL ? (size_t)(comma - list->at) : list->size;
        *element = trim((ll_text){list->at, size});
        size_t used = comma != NULL ? size + 1 : size;
        list->at += used;
        list->size -= used;
        if (element->size > 0)
            return true;
    }
    return false;
}

static bool has_token(ll_text list, const char *token)
{
    ll_text element;
    while (next_element(&list, &element))
        if (equals(element, token))
            return true;
    return false;
}

static bool same(ll_text a, ll_text b)
{
    return a.size == b.size && strncasecmp(a.at, b.at, a.size) == 0;
}

static bool in_list(const char *list, ll_text text)
{
    ll_text rest = {list, list != NULL ? strlen(list) : 0}, element;
    while (next_element(&rest, &element))
        if (same(element, text))
            return true;
    return false;
}

/* ---- heads ---- */

/* Next line without its end; false when it is incomplete. A bare LF also ends a line; otherwise the
 * connection would wait for a CR that never comes. */
static bool next_line(const char **at, const char *end, ll_text *line)
{
    const char *feed = memchr(*at, '\n', (size_t)(end - *at));
    if (feed == NULL)
        return false;
    line->at = *at;
    line->size = (size_t)(feed - *at);
    if (line->size > 0 && line->at[line->size - 1] == '\r')
        line->size--;
    *at = feed + 1;
    return true;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* `METHOD target HTTP/1.x`, single spaces, visible ASCII. `known`: whether it is HTTP/1. */
static bool parse_request_line(ll_text line, ll_head *head, bool *known)
{
    const char *space = memchr(line.at, ' ', line.size);
    if (space == NULL || space == line.at)
        return false;
    head->method = (ll_text){line.at, (size_t)(space - line.at)};
    const char *target = space + 1, *end = line.at + line.size;
    space = memchr(target, ' ', (size_t)(end - target));
    if (space == NULL || space == target)
        return false;
    head->target = (ll_text){target, (size_t)(space - target)};
    ll_text version = {space + 1, (size_t)(end - space - 1)};
    if (version.size != 8 || memcmp(version.at, "HTTP/", 5) != 0 || !is_digit(version.at[5]) ||
        version.at[6] != '.' || !is_digit(version.at[7]))
        return false;
    *known = version.at[5] == '1';
    head->http11 = version.at[7] != '0'; /* RFC 9110 2.5: a higher minor version is as 1.1 */
    for (size_t i = 0; i < head->method.size; i++)
        if (head->method.at[i] < 'A' || head->method.at[i] > 'Z')
            return false;
    for (size_t i = 0; i < head->target.size; i++)
        if (head->target.at[i] <= ' ' || head->target.at[i] == 0x7f)
            return false;
    return true;
}

static void add_protocols(ll_head *head, ll_text list)
{
    ll_text element;
    while (next_element(&list, &element)) {
        head->protocols++;
        for (int f = 0; f < LL_STREAM_PROTOCOLS; f++)
            if (head->protocol_at[f] == 0 && element.size == strlen(ll_stream_protocols[f]) &&
                memcmp(element.at, ll_stream_protocols[f], element.size) == 0)
                head->protocol_at[f] = head->protocols;
    }
}

void ll_head_add(ll_head *head, ll_text name, ll_text value)
{
    value = trim(value);
    const struct {
        const char *name;
        ll_text *value;
    } once[] = {{"Host", &head->host},
                {"Sec-WebSocket-Version", &head->version},
                {"Sec-WebSocket-Key", &head->key},
                {"Origin", &head->origin},
                {"Content-Length", &head->length}};
    if (equals(name, "Upgrade"))
        head->websocket = head->websocket || has_token(value, "websocket");
    else if (equals(name, "Connection"))
        head->upgrade = head->upgrade || has_token(value, "upgrade");
    else if (equals(name, "Sec-WebSocket-Protocol"))
        add_protocols(head, value);
    else if (equals(name, "Transfer-Encoding"))
        head->encoded = true;
    for (size_t i = 0; i < sizeof once / sizeof *once; i++) {
        if (equals(name, once[i].name)) {
            head->twice = once[i].value->at != NULL ? once[i].name : head->twice;
            *once[i].value = trim(value);
        }
    }
}

const ll_head_fault *ll_header_fault(ll_text name, ll_text value)
{
    static const ll_head_fault bad_name = {400, "",
                                           "header: its name must be letters, digits and !#$%&'*+-.^_`|~"},
                               bad_value = {400, "", "header: must not have control characters"},
                               no_length = {400, "Content-Length",
                                            "Content-Length: must be digits and nothing else"},
                               long_length = {413, "Content-Length",
                                              "Content-Length: must have at most 19 digits"};
    if (name.size == 0)
        return &bad_name;
    for (size_t i = 0; i < name.size; i++)
        if (!is_name_character(name.at[i]) &&
            (name.at[i] == '\0' || strchr("!#$%&'*+.^`|~", name.at[i]) == NULL))
            return &bad_name; /* also obsolete line folding */
    bool digits = value.size > 0;
    for (size_t i = 0; i < value.size; i++) {
        char c = value.at[i];
        if ((c >= 0 && c < ' ' && c != '\t') || c == 0x7f)
            return &bad_value;
        digits = digits && is_digit(c);
    }
    if (!equals(name, "Content-Length"))
        return NULL;
    return !digits ? &no_length : value.size > 19 ? &long_length : NULL;
}

static bool parse_field(ll_text line, ll_head *head)
{
    const char *colon = memchr(line.at, ':', line.size);
    if (colon == NULL)
        return false;
    ll_text name = {line.at, (size_t)(colon - line.at)};
    ll_text value = {colon + 1, (size_t)(line.at + line.size - colon - 1)};
    while (value.size > 0 && (*value.at == ' ' || *value.at == '\t')) {
        value.at++;
        value.size--;
    }
    head->fault = ll_header_fault(name, value);
    ll_head_add(head, name, value);
    return head->fault == NULL;
}

/* Checks the first bytes: browsers and scripts send a method in capitals first. */
static ll_head_state parse_beginning(const char *bytes, size_t size)
{
    static const char preface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
    size_t common = size < 14 ? size : 14;
    if (common >= 4 && memcmp(bytes, preface, common) == 0)
        return common < 14 ? LL_HEAD_PARTIAL : LL_HEAD_VERSION;
    for (size_t i = 0; i < size && bytes[i] != ' '; i++)
        if (bytes[i] < 'A' || bytes[i] > 'Z' || i >= 24)
            return LL_HEAD_INVALID;
    return LL_HEAD_PARTIAL;
}

ll_head_state ll_head_parse(const char *bytes, size_t size, ll_head *head)
{
    *head = (ll_head){0};
    const char *at = bytes, *end = bytes + size;
    /* RFC 9112 2.2: empty lines before a request are ignored. */
    while (at < end && (*at == '\r' || *at == '\n'))
        at++;
    ll_head_state state = parse_beginning(at, (size_t)(end - at));
    if (state != LL_HEAD_PARTIAL)
        return state;
    ll_text line;
    if (!next_line(&at, end, &line))
        return LL_HEAD_PARTIAL;
    bool known;
    if (!parse_request_line(line, head, &known))
        return LL_HEAD_INVALID;
    if (!known)
        return LL_HEAD_VERSION;
    while (next_line(&at, end, &line)) {
        if (line.size == 0) {
            head->size = (size_t)(at - bytes);
            return LL_HEAD_WHOLE;
        }
        if (!parse_field(line, head))
            return LL_HEAD_INVALID;
    }
    return LL_HEAD_PARTIAL;
}

/* ---- host and origin ---- */

/* Removes `:port`, of digits alone; `[addr6]` keeps its brackets. */
static ll_text without_port(ll_text host)
{
    size_t size = host.size;
    while (size > 0 && host.at[size - 1] >= '0' && host.at[size - 1] <= '9')
        size--;
    return size > 0 && host.at[size - 1] == ':' ? (ll_text){host.at, size - 1} : host;
}

static bool is_address(ll_text host)
{
    char text[64];
    unsigned char bytes[16];
    bool six = host.size > 2 && host.at[0] == '[' && host.at[host.size - 1] == ']';
    size_t skip = six ? 1 : 0, size = host.size - 2 * skip;
    if (size == 0 || size >= sizeof text)
        return false;
    memcpy(text, host.at + skip, size);
    text[size] = '\0';
    return inet_pton(six ? AF_INET6 : AF_INET, text, bytes) == 1;
}

bool ll_allow_host(const ll_allow *allow, ll_text host)
{
    if (host.at == NULL || host.size == 0)
        return false;
    ll_text name = without_port(host);
    if (is_address(name) || in_list(allow->hosts, host))
        return true;
    name.size -= name.size > 1 && name.at[name.size - 1] == '.'; /* the root of names: the same host */
    return equals(name, "localhost") || in_list(allow->hosts, name);
}

bool ll_allow_origin(const ll_allow *allow, ll_text origin, ll_text host)
{
    if (origin.at == NULL)
        return true;
    if (in_list(allow->origins, origin))
        return true;
    const struct {
        const char *scheme, *port;
    } schemes[] = {{"http://", ":80"}, {"https://", ":443"}};
    for (int i = 0; i < 2; i++) {
        size_t size = strlen(schemes[i].scheme), port = strlen(schemes[i].port);
        if (origin.size <= size || strncasecmp(origin.at, schemes[i].scheme, size) != 0 || host.at == NULL)
            continue;
        ll_text authority = {origin.at + size, origin.size - size}, plain = host;
        if (plain.size > port && strncmp(plain.at + plain.size - port, schemes[i].port, port) == 0)
            plain.size -= port; /* browsers omit the default port in Origin; clients may write it in Host */
        if (same(authority, host) || same(authority, plain))
            return true;
    }
    return false;
}

/* ---- streams ---- */

static bool begins(ll_text text, const char *prefix)
{
    return text.at != NULL && text.size >= strlen(prefix) && memcmp(text.at, prefix, strlen(prefix)) == 0;
}

bool ll_stream_path(ll_text target, ll_stream_kind *kind, char id[65])
{
    static const char *const before[LL_STREAM_KINDS] = {[LL_STREAM_SESSION] = "/api/v1/sessions/",
                                                        [LL_STREAM_EXPERIMENT] = "/api/v1/experiments/",
                                                        [LL_STREAM_CLASS] = "/api/v1/classes/"};
    static const char after[] = "/stream";
    *kind = LL_STREAM_SESSION;
    while (*kind < LL_STREAM_KINDS && !begins(target, before[*kind]))
        ++*kind;
    if (*kind == LL_STREAM_KINDS)
        return false;
    size_t begin = strlen(before[*kind]), i = begin;
    while (i < target.size && is_name_character(target.at[i]))
        i++;
    size_t length = i - begin, rest = target.size - i, wanted = sizeof after - 1;
    if (length == 0 || length > 64 || rest < wanted || memcmp(target.at + i, after, wanted) != 0 ||
        (rest > wanted && target.at[i + wanted] != '?'))
        return false;
    memcpy(id, target.at + begin, length);
    id[length] = '\0';
    return true;
}

static bool is_key(ll_text key)
{
    if (key.at == NULL || key.size != 24 || key.at[22] != '=' || key.at[23] != '=')
        return false;
    for (int i = 0; i < 22; i++) {
        char c = key.at[i];
        if (!is_name_character(c) && c != '+' && c != '/')
            return false;
    }
    return memchr(key.at, '-', 22) == NULL && memchr(key.at, '_', 22) == NULL;
}

/* The client's order decides; only sessions stream anything but JSON. */
static bool choose_protocol(const ll_head *head, ll_stream_kind kind, ll_frame_format *format)
{
    int bin = kind == LL_STREAM_SESSION ? head->protocol_at[LL_FRAME_BINARY] : 0,
        json = head->protocol_at[LL_FRAME_JSON];
    *format = bin != 0 && (json == 0 || bin < json) ? LL_FRAME_BINARY : LL_FRAME_JSON;
    return bin != 0 || json != 0;
}

static bool has_body(const ll_head *head)
{
    ll_text length = head->length;
    while (length.size > 0 && *length.at == '0') {
        length.at++;
        length.size--;
    }
    return head->encoded || length.size > 0;
}

static ll_status refuse(int *http_status, int status, ll_code code, const char *field, const char *text)
{
    *http_status = status;
    return ll_field_error(code, field, "%s", text);
}

ll_status ll_upgrade_check(const ll_head *head, const ll_allow *allow, ll_upgrade *upgrade, int *http_status)
{
    *upgrade = (ll_upgrade){0};
    if (!ll_stream_path(head->target, &upgrade->kind, upgrade->id))
        return refuse(http_status, 404, LL_NOT_FOUND, "", "not the path of a stream");
    if (!equals(head->method, "GET"))
        return refuse(http_status, 405, LL_BAD_INPUT, "", "method: must be GET for a stream");
    if (head->twice != NULL) {
        *http_status = 400;
        return ll_field_error(LL_BAD_INPUT, head->twice, "%s: must come once", head->twice);
    }
    if (has_body(head)) {
        return refuse(http_status, 400, LL_BAD_INPUT, head->encoded ? "Transfer-Encoding" : "Content-Length",
                      "body: an upgrade must have none");
    }
    if (!ll_allow_host(allow, head->host)) {
        return refuse(http_status, 421, LL_FORBIDDEN, "Host",
                      "Host: must be localhost, an address or a name given by --allow-host");
    }
    if (!head->websocket || !head->upgrade || !head->http11) {
        return refuse(http_status, 426, LL_BAD_INPUT, "Upgrade",
                      "not a WebSocket upgrade: send `Connection: Upgrade` and `Upgrade: websocket`");
    }
    if (!equals(head->version, "13")) {
        return refuse(http_status, 426, LL_BAD_INPUT, "Sec-WebSocket-Version",
                      "Sec-WebSocket-Version: must be 13");
    }
    if (!is_key(head->key)) {
        return refuse(http_status, 400, LL_BAD_INPUT, "Sec-WebSocket-Key",
                      "Sec-WebSocket-Key: must be 16 bytes in base64 (24 characters)");
    }
    if (!choose_protocol(head, upgrade->kind, &upgrade->format)) {
        return refuse(http_status, 400, LL_BAD_INPUT, "Sec-WebSocket-Protocol",
                      upgrade->kind == LL_STREAM_SESSION
                          ? "Sec-WebSocket-Protocol: must be laglab.v2.bin or laglab.v2.json"
                          : "Sec-WebSocket-Protocol: must be laglab.v2.json");
    }
    if (!ll_allow_origin(allow, head->origin, head->host)) {
        return refuse(http_status, 403, LL_FORBIDDEN, "Origin",
                      "Origin not allowed to open streams; see --allow-origin");
    }
    memcpy(upgrade->key, head->key.at, 24);
    upgrade->key[24] = '\0';
    *http_status = 101;
    return ll_ok();
}
