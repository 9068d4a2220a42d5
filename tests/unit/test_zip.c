/* SPDX-License-Identifier: MIT */
/* An archive beyond 4 GiB, most of it a hole in the file, as Python's zipfile reads it. */
#include "api/format/zip.h"

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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_zip_beyond_four_gigabytes),
    };
    return cmocka_run_group_tests_name("zip", tests, NULL, NULL);
}
