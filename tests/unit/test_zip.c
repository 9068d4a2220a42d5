/* SPDX-License-Identifier: MIT */
/* Archives as Python's zipfile reads them: beyond 4 GiB, most of it a hole in the file, and of
 * entries that are packed as they come. */
#include "api/format/zip.h"
#include "api/format/zip_writer.h"

#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

static const uint64_t large = (uint64_t)5 << 30;

static const char reader[] =
    "python3 -c '\n"
    "import sys, zipfile\n"
    "archive = zipfile.ZipFile(sys.argv[1])\n"
    "sizes = [(entry.filename, entry.file_size) for entry in archive.infolist()]\n"
    "assert sizes == [(\"first\", 5), (\"hole\", 5 << 30), (\"last\", 4)], sizes\n"
    "assert archive.read(\"first\") == b\"small\" and archive.read(\"last\") == b\"tail\"\n"
    "assert archive.open(\"hole\").read(1000) == bytes(1000)\n"
    "' ";

static void append(FILE *file, struct api_text *text, size_t *written) {
    assert_false(text->failed);
    assert_int_equal(fwrite(text->bytes + *written, 1, text->length - *written, file),
                     text->length - *written);
    *written = text->length;
}

static void write_archive(FILE *file, struct arena *arena) {
    static const char *const contents[] = {"small", NULL, "tail"};
    struct zip_entry entries[] = {{.name = "first"}, {.name = "hole"}, {.name = "last"}};
    struct api_text text = api_text_growing(arena);
    size_t written = 0;
    for (int k = 0; k < 3; k++) {
        struct zip_entry *entry = &entries[k];
        entry->offset = (uint64_t)ftello(file);
        entry->size = entry->packed = contents[k] ? strlen(contents[k]) : large;
        if (contents[k])
            entry->crc = (uint32_t)crc32(0, (const Bytef *)contents[k], (uInt)entry->size);
        zip_begin_entry(&text, entry);
        append(file, &text, &written);
        if (contents[k])
            fputs(contents[k], file);
        else
            assert_int_equal(fseeko(file, (off_t)large, SEEK_CUR), 0);
    }
    uint64_t offset = (uint64_t)ftello(file);
    zip_end(&text, entries, 3, offset);
    append(file, &text, &written);
}

static void test_zip_beyond_four_gigabytes(void **state) {
    char path[] = "/tmp/draped-zip-XXXXXX", command[sizeof reader + sizeof path];
    int descriptor = mkstemp(path);
    FILE *file = fdopen(descriptor, "wb");
    struct arena *arena = arena_new((size_t)1 << 20);
    (void)state;
    assert_non_null(file);
    write_archive(file, arena);
    assert_int_equal(fclose(file), 0);
    snprintf(command, sizeof command, "%s%s", reader, path);
    int status = system(command);
    unlink(path);
    arena_free(arena);
    assert_int_equal(status, 0);
}

/* Of more entries than there was room for at first, one of noise that does not pack, written in
 * pieces, an empty one, and of a sink that takes no more. */
static void test_zip_is_packed_as_it_comes(void **state) {
    enum { ENTRIES = 70, NOISE = 300000, PIECE = 1001 };
    static const char check[] =
        "python3 -c '\n"
        "import sys, zipfile\n"
        "archive = zipfile.ZipFile(sys.argv[1])\n"
        "assert archive.testzip() is None\n"
        "sizes = [entry.file_size for entry in archive.infolist()]\n"
        "assert sizes == [300000] + [k % 3 for k in range(1, 70)], sizes\n"
        "assert archive.read(\"entry 8\") == b\"no\" and archive.namelist()[69] == \"entry 69\"\n"
        "' ";
    char path[] = "/tmp/draped-zip-XXXXXX", command[sizeof check + sizeof path], name[20];
    unsigned char *noise = malloc(NOISE);
    struct random random = random_begin("noise");
    struct bytes archive = {0};
    const struct api_sink sink = sink_into(&archive);
    struct zip_writer *writer = zip_writer_new(&sink);
    uint64_t size = 0;
    (void)state;
    assert_non_null(noise);
    for (size_t k = 0; k < NOISE; k++)
        noise[k] = (unsigned char)random_index(&random, 256);
    for (int k = 0; k < ENTRIES; k++) {
        snprintf(name, sizeof name, "entry %d", k);
        assert_true(zip_writer_open(writer, name));
        for (size_t at = 0; at < NOISE && k == 0; at += PIECE)
            assert_true(
                zip_writer_write(writer, noise + at, NOISE - at < PIECE ? NOISE - at : PIECE));
        assert_true(zip_writer_write(writer, "no", (size_t)k % 3));
        assert_true(zip_writer_close(writer, &size));
        assert_int_equal(size, k ? k % 3 : NOISE);
    }
    assert_true(zip_writer_end(writer));
    assert_int_equal(zip_writer_fault(writer), ZIP_SOUND);
    zip_writer_free(writer);
    FILE *file = fdopen(mkstemp(path), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(archive.data, 1, archive.length, file), archive.length);
    assert_int_equal(fclose(file), 0);
    snprintf(command, sizeof command, "%s%s", check, path);
    int status = system(command);
    unlink(path);
    assert_int_equal(status, 0);
    bytes_free(&archive);
    free(noise);
}

static bool take_so_many(void *context, const void *bytes, size_t length) {
    size_t *left = context;
    (void)bytes;
    return length == 0 || (*left)-- > 0;
}

/* What a fault was stays, and nothing more is done. */
static void test_zip_tells_its_first_fault(void **state) {
    size_t left = 2;
    uint64_t size;
    const struct api_sink sink = {.write = take_so_many, .context = &left};
    struct zip_writer *writer = zip_writer_new(&sink);
    (void)state;
    assert_true(zip_writer_open(writer, "large"));
    assert_true(zip_writer_write(writer, "a", 1));
    assert_false(zip_writer_write(writer, "a", UINT32_MAX));
    assert_int_equal(zip_writer_fault(writer), ZIP_TOO_LARGE);
    assert_false(zip_writer_write(writer, "a", 0));
    assert_false(zip_writer_close(writer, &size));
    assert_false(zip_writer_open(writer, "next"));
    assert_false(zip_writer_end(writer));
    zip_writer_free(writer);
    left = 1;
    writer = zip_writer_new(&sink);
    assert_true(zip_writer_open(writer, "small"));
    assert_true(zip_writer_write(writer, "a", 1));
    assert_false(zip_writer_close(writer, &size));
    assert_int_equal(zip_writer_fault(writer), ZIP_REFUSED);
    zip_writer_free(writer);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_zip_beyond_four_gigabytes),
        cmocka_unit_test(test_zip_is_packed_as_it_comes),
        cmocka_unit_test(test_zip_tells_its_first_fault),
    };
    return cmocka_run_group_tests_name("zip", tests, NULL, NULL);
}
