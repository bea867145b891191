/* Constant documents: what is in a folder, the digest of all, addresses in pages, compression by several
 * threads. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "daemon/http/documents.h"

static char folder[64];

static void write_file(const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static int set_up(void **state)
{
    (void)state;
    char path[128];
    snprintf(folder, sizeof folder, "/tmp/laglab-documents-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/js", folder);
    mkdir(path, 0755);
    snprintf(path, sizeof path, "%s/.git", folder);
    mkdir(path, 0755);
    write_file("index.html",
               "<a href=\"\">=\"</a><link href=\"js/a.js\"><a href=\"/js/a.js\"><img src=\"js/b.js\">");
    write_file("js/a.js", "export {};");
    write_file("js/page.html", "<script src=\"js/a.js\">");
    write_file("js/.b.js", "hidden");
    write_file(".git/config", "hidden");
    write_file("empty.txt", "");
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    static const char *const names[] = {"index.html",  "js/a.js",   "js/page.html", "js/.b.js", "js",
                                        ".git/config", "empty.txt", ".git",         ""};
    char path[128];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        assert_int_equal(remove(path), 0);
    }
    return 0;
}

static void read_all(ll_documents *documents)
{
    ll_status status = ll_documents_read(documents, folder);
    LL_THEN(status, ll_documents_add(documents, "/api?a=1", "application/json", strdup("{}"), 2));
    LL_THEN(status, ll_documents_finish(documents));
    assert_false(ll_failed(&status));
}

static void test_folder(void **state)
{
    (void)state;
    ll_documents documents = {0};
    read_all(&documents);
    assert_int_equal(documents.count, 5);
    assert_string_equal(ll_documents_find(&documents, "/js/a.js")->type, "text/javascript; charset=utf-8");
    assert_int_equal(ll_documents_find(&documents, "/empty.txt")->size, 0);
    assert_string_equal(ll_documents_find(&documents, "/api?a=1")->bytes, "{}");
    assert_null(ll_documents_find(&documents, "/js/.b.js"));
    assert_null(ll_documents_find(&documents, "/.git/config"));
    char expected[256];
    snprintf(expected, sizeof expected,
             "<a href=\"\">=\"</a><link href=\"%s/js/a.js\"><a href=\"/js/a.js\"><img src=\"js/b.js\">",
             documents.digest);
    assert_string_equal(ll_documents_find(&documents, "/index.html")->bytes, expected);
    assert_int_equal(ll_documents_find(&documents, "/index.html")->size, strlen(expected));
    assert_string_equal(ll_documents_find(&documents, "/js/page.html")->bytes, "<script src=\"js/a.js\">");
    ll_documents_free(&documents);

    char large[128];
    snprintf(large, sizeof large, "%s/large.bin", folder);
    write_file("large.bin", "");
    assert_int_equal(truncate(large, (64 << 20) + 1), 0);
    ll_status status = ll_documents_read(&documents, folder);
    assert_int_equal(status.code, LL_LIMIT);
    assert_non_null(strstr(status.text, "large.bin: must have at most 64 MiB"));
    ll_documents_free(&documents);
    remove(large);

    ll_documents none = {0};
    status = ll_documents_read(&none, "/nonexistent/www");
    assert_int_equal(status.code, LL_NOT_FOUND);
    assert_non_null(strstr(status.text, "/nonexistent/www"));
    status = ll_documents_finish(&none);
    assert_false(ll_failed(&status));
    assert_null(ll_documents_find(&none, "/index.html"));
    ll_documents_free(&none);
}

/* Equal for the same documents; another for another text, or another name. */
static void test_digest(void **state)
{
    (void)state;
    char first[LL_DOCUMENT_DIGEST + 1], page[LL_DOCUMENT_DIGEST + 1];
    ll_documents documents = {0};
    read_all(&documents);
    memcpy(first, documents.digest, sizeof first);
    memcpy(page, ll_documents_find(&documents, "/index.html")->tag, sizeof page);
    assert_int_equal(strspn(first, "0123456789abcdef"), LL_DOCUMENT_DIGEST);
    ll_documents_free(&documents);
    read_all(&documents);
    assert_string_equal(documents.digest, first);
    ll_documents_free(&documents);
    write_file("js/a.js", "export { };");
    read_all(&documents);
    assert_string_not_equal(documents.digest, first);
    assert_string_not_equal(ll_documents_find(&documents, "/index.html")->tag,
                            page); /* it names the digest */
    ll_documents_free(&documents);
    write_file("js/a.js", "export {};");

    ll_documents one = {0}, other = {0};
    ll_documents_add(&one, "/ab", "text/plain", strdup("c"), 1);
    ll_documents_add(&other, "/a", "text/plain", strdup("c"), 1);
    ll_documents_finish(&one);
    ll_documents_finish(&other);
    assert_string_not_equal(one.digest, other.digest);
    ll_documents_free(&one);
    ll_documents_free(&other);
}

static void *compress(void *document)
{
    return (void *)(uintptr_t)ll_document_compressed(document);
}

static void test_compression(void **state)
{
    (void)state;
    ll_documents documents = {0};
    pthread_t threads[8];
    enum { SIZE = 300000 };
    char *text = malloc(SIZE);
    assert_non_null(text);
    for (int i = 0; i < SIZE; i++) {
        text[i] = (char)('a' + i * 7 % 26);
    }
    ll_documents_add(&documents, "/long", "text/plain", text, SIZE);
    ll_documents_add(&documents, "/short", "text/plain", strdup("x"), 1);
    ll_documents_add(&documents, "/picture", "image/png", calloc(1, 5000), 5000);
    ll_documents_finish(&documents);
    for (int i = 0; i < 8; i++) {
        pthread_create(&threads[i], NULL, compress, ll_documents_find(&documents, "/long"));
    }
    const ll_document_gzip *gzip = ll_document_compressed(ll_documents_find(&documents, "/long"));
    assert_non_null(gzip);
    assert_in_range(gzip->size, 20, SIZE / 100);
    for (int i = 0; i < 8; i++) {
        void *same = NULL;
        pthread_join(threads[i], &same);
        assert_ptr_equal(same, gzip);
    }
    assert_null(ll_document_compressed(ll_documents_find(&documents, "/short")));
    assert_null(ll_document_compressed(ll_documents_find(&documents, "/picture")));
    ll_documents_free(&documents);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_folder),
        cmocka_unit_test(test_digest),
        cmocka_unit_test(test_compression),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
