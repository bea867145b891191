/* Encoding and decoding of rows: sequences of sections of every form, and extreme numbers.
 * With the argument `vectors` it prints such sequences for other decoders (tests/page/records.test.mjs). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "record/sample.h"
#include "support/decode.h"
#include "support/table_valid.h"

enum { CHAIN = 400 };

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static void tables_are_sound(void **state)
{
    (void)state;
    for (int i = 0; i < SAMPLES; i++)
        must(record_valid(&samples[i]));
    ll_record bad = samples[1];
    bad.keys = 2;
    assert_int_equal(record_valid(&bad).code, LL_BAD_INPUT);
    ll_record_field fields[] = {sample_fields[0], sample_fields[0]};
    bad = (ll_record){.name = "twice",
                      .channel = LL_CHANNEL_SCENE,
                      .help = "x",
                      .form = LL_FORM_ONE,
                      .fields = fields,
                      .count = 2};
    assert_int_equal(record_valid(&bad).code, LL_BAD_INPUT);
}

/* The nearest value that a field can have, computed with long doubles. */
static void values_are_the_nearest(void **state)
{
    (void)state;
    draw d = {7, 0};
    const ll_record_field *x = &sample_fields[7], *energy = &sample_fields[8];
    for (int i = 0; i < 20000; i++) {
        sample s;
        draw_sample(&d, &s);
        double v = ll_field_value(x, ll_field_integer(x, &s)),
               e = ll_field_value(energy, ll_field_integer(energy, &s));
        if (isfinite(s.x) && fabs((double)s.x) < 1e9)
            assert_true(fabsl((long double)v - (long double)s.x) <= 0.5L / 8192);
        if (isfinite(s.energy) && s.energy != 0 && fabs(s.energy) < 1e300 && fabs(s.energy) > 1e-290)
            assert_true(fabsl((long double)e - (long double)s.energy) <=
                        fabsl((long double)s.energy) * 0x1p-24L);
        assert_int_equal(isnan(v), isnan(s.x));
        assert_int_equal(isnan(e), isnan(s.energy));
        if (isinf(s.energy))
            assert_true(e == s.energy);
    }
}

static void a_float_survives_in_23_bits(void **state)
{
    typedef struct {
        float f;
    } row;
    const ll_record_field field = LL_REAL(row, f, 23, NULL, "a float");
    draw d = {8, 0};
    (void)state;
    for (int i = 0; i < 100000; i++) {
        uint32_t bits = (uint32_t)draw_below(&d, UINT64_C(1) << 32);
        row r;
        memcpy(&r.f, &bits, sizeof bits);
        double v = ll_field_value(&field, ll_field_integer(&field, &r));
        assert_true(r.f != r.f ? v != v : (float)v == r.f);
    }
}

static void assert_decodes(const ll_rows *rows, const ll_rows *base, ll_rows *seen)
{
    assert_int_equal(seen->count + seen->first, rows->count + rows->first);
    int skipped = rows->count - seen->count;
    if (rows->record->form != LL_FORM_LOG)
        assert_int_equal(skipped, 0);
    else if (base != NULL)
        assert_true(seen->first >= base->first + base->count);
    size_t size = (size_t)seen->count * (size_t)rows->record->count * sizeof(int64_t);
    assert_memory_equal(seen->values, ll_rows_at(rows, skipped), size + 0);
    assert_int_equal(seen->plane_bytes, rows->plane_bytes);
    if (rows->plane_bytes > 0)
        assert_memory_equal(seen->planes, rows->planes, rows->plane_bytes);
}

/* Each section is a delta against the rows that the reader has decoded so far. */
static void chains_come_out_as_they_went_in(void **state)
{
    (void)state;
    for (int r = 0; r < SAMPLES; r++) {
        draw d = {(uint64_t)r + 20, 0};
        ll_rows *base = NULL, *read = NULL;
        for (int i = 0; i < CHAIN; i++) {
            ll_buffer bytes = {0};
            bool whole = base == NULL || draw_below(&d, 10) == 0;
            ll_rows *rows = draw_rows(&d, &samples[r], base), *seen = NULL;
            ll_rows_encode(rows, whole ? NULL : base, &bytes);
            must(ll_rows_decode(&samples[r], whole ? NULL : read, bytes.bytes, bytes.size, &seen));
            assert_decodes(rows, whole ? NULL : base, seen);
            free(bytes.bytes);
            ll_rows_free(base);
            ll_rows_free(read);
            base = rows;
            read = seen;
        }
        ll_rows_free(base);
        ll_rows_free(read);
    }
}

static void unchanged_rows_cost_few_bytes(void **state)
{
    (void)state;
    for (int r = 0; r < SAMPLES; r++) {
        draw d = {(uint64_t)r + 40, 0};
        ll_buffer bytes = {0};
        ll_rows *rows = draw_rows(&d, &samples[r], NULL);
        assert_true(ll_rows_equal(rows, rows));
        ll_rows_encode(rows, rows, &bytes);
        assert_true(bytes.size <=
                    6 + (samples[r].form == LL_FORM_GRID ? (size_t)rows->count + rows->plane_bytes : 0));
        free(bytes.bytes);
        ll_rows_free(rows);
    }
}

static void an_older_table_reads_the_fields_that_it_knows(void **state)
{
    (void)state;
    for (int r = 0; r < LL_FORM_LOG; r++) {
        ll_record old = samples[r];
        old.count -= 3;
        draw d = {(uint64_t)r + 80, 0};
        ll_rows *base = NULL, *read = NULL;
        for (int i = 0; i < 50; i++) {
            ll_buffer bytes = {0};
            ll_rows *rows = draw_rows(&d, &samples[r], base), *seen = NULL;
            ll_rows_encode(rows, base, &bytes);
            must(ll_rows_decode(&old, read, bytes.bytes, bytes.size, &seen));
            assert_int_equal(seen->count, rows->count);
            for (int k = 0; k < rows->count; k++)
                assert_memory_equal(ll_rows_at(seen, k), ll_rows_at(rows, k),
                                    (size_t)old.count * sizeof(int64_t));
            free(bytes.bytes);
            ll_rows_free(base);
            ll_rows_free(read);
            base = rows;
            read = seen;
        }
        ll_rows_free(base);
        ll_rows_free(read);
    }
}

static void json_names_each_field(void **state)
{
    (void)state;
    sample s = {.width = 1,
                .number = 3,
                .sign = -2,
                .big = INT64_C(1) << 50,
                .on = true,
                .kind = 1,
                .x = 0.1F,
                .energy = INFINITY,
                .ms = 2.5};
    ll_buffer text = {0};
    ll_rows *rows = ll_rows_new(&samples[3], 1);
    rows->first = 41;
    ll_rows_add(rows, &s, 1);
    ll_rows_add(rows, &s, 1);
    ll_rows_json(rows, 42, &text);
    ll_buffer_add(&text, "", 1);
    assert_string_equal(
        text.bytes, "[{\"id\":42,\"width\":1,\"height\":0,\"number\":3,\"sign\":-2,\"big\":1125899906842624,"
                    "\"on\":true,\"kind\":\"pie\",\"x\":0.0999755859375,\"energy\":null,\"ms\":2.5}]");
    free(text.bytes);
    ll_rows_free(rows);
}

/* ---- for other decoders ---- */

static void print_hex(const ll_buffer *bytes)
{
    for (size_t i = 0; i < bytes->size; i++)
        printf("%02x", (unsigned char)bytes->bytes[i]);
}

/* One line per section: {"record","whole","bytes","rows"}. */
static void print_vectors(int chain)
{
    for (int r = 0; r < SAMPLES; r++) {
        draw d = {(uint64_t)r + 20, 0};
        ll_rows *base = NULL;
        for (int i = 0; i < chain; i++) {
            ll_buffer bytes = {0}, json = {0};
            bool whole = base == NULL || draw_below(&d, 10) == 0;
            ll_rows *rows = draw_rows(&d, &samples[r], base);
            ll_rows_encode(rows, whole ? NULL : base, &bytes);
            ll_rows_json(rows, whole || base == NULL ? 0 : base->first + base->count, &json);
            printf("{\"record\":\"%s\",\"whole\":%s,\"bytes\":\"", samples[r].name, whole ? "true" : "false");
            print_hex(&bytes);
            printf("\",\"rows\":%.*s}\n", (int)json.size, json.bytes);
            free(bytes.bytes);
            free(json.bytes);
            ll_rows_free(base);
            base = rows;
        }
        ll_rows_free(base);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_sound),
        cmocka_unit_test(values_are_the_nearest),
        cmocka_unit_test(a_float_survives_in_23_bits),
        cmocka_unit_test(chains_come_out_as_they_went_in),
        cmocka_unit_test(unchanged_rows_cost_few_bytes),
        cmocka_unit_test(an_older_table_reads_the_fields_that_it_knows),
        cmocka_unit_test(json_names_each_field),
    };
    if (argc > 2 && strcmp(argv[1], "vectors") == 0) {
        print_vectors(atoi(argv[2]));
        return 0;
    }
    return cmocka_run_group_tests_name("record", tests, NULL, NULL);
}
