/* Heights of PNG pictures, written here byte by byte without compression.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "scarce.h"
#include "small.h"

#include <stdint.h>
#include <stdlib.h>

/* ---- a PNG ---- */

enum { GREY = 0, COLOUR = 2, LONGEST = 1 << 14 };

typedef struct picture {
    unsigned char bytes[LONGEST];
    size_t size;
    int end; /* how many bytes of it are there, if not negative */
} picture;

static picture shown;

static void put_word(unsigned char *to, uint32_t value)
{
    for (int k = 0; k < 4; ++k) to[k] = (unsigned char)(value >> (24 - 8 * k));
}

/* The check of bytes, bit by bit. */
static uint32_t checked(const unsigned char *bytes, size_t size)
{
    uint32_t rest = 0xffffffffu;
    for (size_t k = 0; k < size; ++k) {
        rest ^= bytes[k];
        for (int l = 0; l < 8; ++l) rest = rest >> 1 ^ (rest & 1 ? 0xedb88320u : 0);
    }
    return ~rest;
}

static void add_chunk(picture *p, const char kind[5], const unsigned char *data, size_t size)
{
    unsigned char *at = p->bytes + p->size;
    put_word(at, (uint32_t)size);
    memcpy(at + 4, kind, 4);
    memcpy(at + 8, data, size);
    put_word(at + 8 + size, checked(at + 4, size + 4));
    p->size += 12 + size;
}

/* Rows of so many bytes each; deflate's block without compression. */
static void draw(picture *p, int columns, int rows, int bits, int kind, const unsigned char *row,
                 int bytes)
{
    static const unsigned char first[8] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10};
    const unsigned char end[] = {0};
    unsigned char head[13] = {0}, data[LONGEST / 2] = {0x78, 1, 1};
    const unsigned length = (unsigned)(rows * (bytes + 1));
    uint32_t low = 1, high = 0;
    *p = (picture){.size = sizeof first, .end = -1};
    memcpy(p->bytes, first, sizeof first);
    put_word(head, (uint32_t)columns);
    put_word(head + 4, (uint32_t)rows);
    head[8] = (unsigned char)bits, head[9] = (unsigned char)kind;
    add_chunk(p, "IHDR", head, sizeof head);
    data[3] = length & 255, data[4] = (unsigned char)(length >> 8);
    data[5] = data[3] ^ 255, data[6] = data[4] ^ 255;
    for (int j = 0; j < rows; ++j)
        memcpy(data + 8 + j * (bytes + 1), row + j * bytes, (size_t)bytes);
    for (unsigned k = 0; k < length; ++k)
        low = (low + data[7 + k]) % 65521, high = (high + low) % 65521;
    put_word(data + 7 + length, high << 16 | low);
    add_chunk(p, "IDAT", data, 11 + length);
    add_chunk(p, "IEND", end, 0);
}

static int load_shown(void *user, const char *path, const char **text, size_t *size)
{
    (void)user;
    *text = (const char *)shown.bytes;
    *size = shown.end < 0 ? shown.size : (size_t)shown.end;
    return strstr(path, "h.png") ? 0 : 2;
}

static mbsr_file_opt with_pictures(void)
{
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.load = load_shown;
    return opt;
}

static const char mjcf[] = "<mujoco><asset><hfield name='h' file='h.png' size='2 1 4 .5'/></asset>"
                           "<worldbody><geom type='hfield' hfield='h'/></worldbody></mujoco>";

#define SDF(more)                                                                                  \
    "<sdf version='1.9'><model name='m'><static>1</static><link name='l'><collision name='c'>"     \
    "<pose>0 0 1 0 0 0</pose><geometry><heightmap>" more "</heightmap></geometry></collision>"     \
    "</link></model></sdf>"

static const unsigned char grey[] = {10, 60, 110, 160, 210, 250};

/* ---- tests ---- */

#if defined(TEST_WITH_PNG)

static void assert_heights(const char *text, const double height[6])
{
    const mbsr_file_opt opt = with_pictures();
    mbsr_file *file = read_small(text, &opt);
    assert_int_equal(file->findings, 0);
    assert_int_equal(file->shapes, 1);
    assert_int_equal(file->shape->kind, MBSR_SHAPE_HEIGHTS);
    assert_int_equal(file->shape->rows, 2);
    assert_int_equal(file->shape->columns, 3);
    for (int k = 0; k < 6; ++k) assert_close(file->shape->height[k], height[k], 1e-12);
    mbsr_file_destroy(file);
}

/* What MuJoCo 3.14 makes of the same files, but for 16 bits, of which it takes the upper eight. */
static void heights_are_those_of_mujoco(void **unused)
{
    (void)unused;
    static const double of_grey[6] = {2.5, 10.0 / 3.0, 4.0, 0.0, 5.0 / 6.0, 5.0 / 3.0};
    static const unsigned char four[4] = {0x1f, 0x30, 0x25, 0xe0};
    unsigned char colours[18], wide[12];
    draw(&shown, 3, 2, 8, GREY, grey, 3);
    assert_heights(mjcf, of_grey);
    for (int k = 0; k < 18; ++k) colours[k] = k % 3 ? (unsigned char)k : grey[k / 3];
    draw(&shown, 3, 2, 8, COLOUR, colours, 9);
    assert_heights(mjcf, of_grey);
    draw(&shown, 3, 2, 4, GREY, four, 2);
    assert_heights(mjcf,
                   (const double[6]){4.0 / 14.0, 16.0 / 14.0, 52.0 / 14.0, 0.0, 4.0, 8.0 / 14.0});
    for (int k = 0; k < 12; ++k) wide[k] = k % 2 ? (unsigned char)(17 * k) : grey[k / 2];
    double fine[6], height[6];
    for (int k = 0; k < 6; ++k) fine[k] = 256.0 * wide[2 * k] + wide[2 * k + 1];
    for (int k = 0; k < 6; ++k)
        height[k] = 4.0 * (fine[(k + 3) % 6] - fine[0]) / (fine[5] - fine[0]);
    draw(&shown, 3, 2, 16, GREY, wide, 6);
    assert_heights(mjcf, height);
}

/* Black is zero, the brightest point as high as the size says; y grows up the picture. */
static void heights_are_those_of_gazebo(void **unused)
{
    (void)unused;
    const mbsr_file_opt opt = with_pictures();
    double height[6];
    for (int k = 0; k < 6; ++k) height[k] = 5.0 * grey[(k + 3) % 6] / 250.0;
    draw(&shown, 3, 2, 8, GREY, grey, 3);
    static const char text[] = SDF("<uri>file://h.png</uri><size>8 6 5</size><pos>1 2 3</pos>");
    assert_heights(text, height);
    mbsr_file *file = read_small(text, &opt);
    assert_close(file->shape->size[0], 4.0, 1e-15);
    assert_close(file->shape->size[1], 3.0, 1e-15);
    for (int k = 0; k < 3; ++k) assert_close(file->shape->frame.x[k], k < 2 ? k + 1.0 : 4.0, 1e-15);
    mbsr_file_destroy(file);
    assert_file_refused(SDF(""), &opt, "no uri");
    assert_file_refused(SDF("<uri>h.png</uri><size>1 1 0</size>"), &opt, "three positive numbers");
    draw(&shown, 3, 2, 8, GREY, (const unsigned char[6]){0}, 3);
    assert_heights(SDF("<uri>h.png</uri>"), (const double[6]){0.0});
}

static void assert_left_out(const char *words)
{
    const char *const text[] = {mjcf, SDF("<uri>h.png</uri>")};
    const mbsr_file_opt opt = with_pictures();
    for (int k = 0; k < 2; ++k) {
        mbsr_file *file = read_small(text[k], &opt);
        assert_int_equal(file->shapes, 0);
        assert_int_equal(file->findings, 1);
        assert_contains(file->finding[0].text, "it is left out with h");
        assert_contains(file->finding[0].text, words);
        mbsr_file_destroy(file);
    }
}

static void broken_pictures_are_left_out(void **unused)
{
    (void)unused;
    draw(&shown, 1, 1, 8, GREY, grey, 1);
    assert_left_out("less than two rows or columns");
    draw(&shown, 9000, 1, 1, GREY, (const unsigned char[1125]){0}, 1125);
    assert_left_out("less than two rows");
    draw(&shown, 9000, 2, 1, GREY, (const unsigned char[2250]){0}, 1125);
    assert_left_out("more than 8192 rows or columns");
    draw(&shown, 3, 2, 8, GREY, grey, 3);
    for (shown.end = 8; shown.end < (int)shown.size; ++shown.end) assert_left_out("no whole PNG");
    shown.end = -1;
    for (size_t k = 8; k < shown.size; ++k) { /* each chunk has a check */
        shown.bytes[k] ^= 0x10;
        assert_left_out("no whole PNG");
        shown.bytes[k] ^= 0x10;
    }
    shown.bytes[0] = 'P';
    assert_left_out("neither a PNG nor a binary file");
}

static int reads(void *user)
{
    const mbsr_file_opt opt = with_pictures();
    mbsr_file *file;
    mbsr_error error;
    const int status = mbsr_file_read(user, strlen(user), "small", &opt, &file, &error);
    mbsr_file_destroy(file);
    return status;
}

static void each_allocation_fails(void **unused)
{
    (void)unused;
    static char text[][400] = {SDF("<uri>h.png</uri>"), ""};
    strcpy(text[1], mjcf);
    draw(&shown, 3, 2, 8, GREY, grey, 3);
    for (int k = 0; k < 2; ++k) {
        const long count = test_scarce_each(reads, text[k], MBSR_ERR_NO_MEMORY, 1);
        if (count == -2)
            fail_msg("allocation %ld: %ld are left", test_memory.fail_at, test_memory.live);
        assert_true(count == -1 || count > 20);
    }
}

#else

static void pictures_need_libpng(void **unused)
{
    (void)unused;
    const mbsr_file_opt opt = with_pictures();
    const char *const text[] = {mjcf, SDF("<uri>h.png</uri>")};
    draw(&shown, 3, 2, 8, GREY, grey, 3);
    for (int k = 0; k < 2; ++k) {
        mbsr_file *file = read_small(text[k], &opt);
        assert_int_equal(file->shapes, 0);
        assert_contains(file->finding[0].text, "built without libpng");
        mbsr_file_destroy(file);
    }
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#if defined(TEST_WITH_PNG)
        cmocka_unit_test(heights_are_those_of_mujoco),
        cmocka_unit_test(heights_are_those_of_gazebo),
        cmocka_unit_test(broken_pictures_are_left_out),
        cmocka_unit_test(each_allocation_fails),
#else
        cmocka_unit_test(pictures_need_libpng),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
