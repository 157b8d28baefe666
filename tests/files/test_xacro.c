/* What files of xacro say, construct by construct, and what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "xacro_small.h"

#include <stdio.h>
#include <stdlib.h>

static void properties_are_evaluated_when_they_are_used(void **state)
{
    (void)state;
    assert_expands(XACRO("<xacro:property name='a' value='${b * 2}'/>"
                         "<xacro:property name='b' value='0.5'/><l v='${a} x$${a}'/>"),
                   "<l v=\"1.0 x${a}\"/>");
    assert_expands(XACRO("<xacro:property name='b' value='1'/>"
                         "<xacro:property name='a' value='${b}' lazy_eval='false'/>"
                         "<xacro:property name='b' value='2'/><l v='${a}${b}'/>"),
                   "<l v=\"12\"/>");
    assert_expands(XACRO("<xacro:property name='a' value='1'/>"
                         "<xacro:property name='a' default='2'/>"
                         "<xacro:property name='b' default='3'/><l v='${a}${b}'/>"
                         "<xacro:property name='a' remove='true'/>"
                         "<xacro:property name='a' default='4'/><l v='${a}'/>"),
                   "<l v=\"13\"/><l v=\"4\"/>");
    /* literals: numbers, truth values, quoted texts, numbers with underscores are texts */
    assert_expands(XACRO("<xacro:property name='a' value='007'/>"
                         "<xacro:property name='b' value='true'/>"
                         "<xacro:property name='c' value=\"'5'\"/>"
                         "<xacro:property name='d' value='1_0'/>"
                         "<l v='${a + 1} ${b} ${c} ${d}'/>"),
                   "<l v=\"8 True 5 1_0\"/>");
    assert_expands(XACRO("<xacro:property name='mass'><m v='${x}'/><n/></xacro:property>"
                         "<xacro:property name='x' value='3'/>"
                         "<l><xacro:insert_block name='mass'/></l>"),
                   "<l><m v=\"3\"/><n/></l>");
}

static void scopes_are_those_of_calls(void **state)
{
    (void)state;
    assert_expands(
        XACRO("<xacro:macro name='m' params='x'>"
              "<xacro:property name='here' value='${x}'/>"
              "<xacro:property name='up' scope='parent' value='${2 * here}'/>"
              "<xacro:property name='all' scope='global' value='${3 * here}'/>"
              "</xacro:macro>"
              "<xacro:macro name='n' params=''><xacro:m x='5'/><l v='${up}'/></xacro:macro>"
              "<xacro:property name='up' value='0'/><xacro:property name='here' value='0'/>"
              "<xacro:n/><l v='${up} ${here} ${all}'/>"),
        "<l v=\"10\"/><l v=\"0 0 15\"/>");
    /* a macro sees what its caller has */
    assert_expands(XACRO("<xacro:macro name='inner'><l v='${x}'/></xacro:macro>"
                         "<xacro:macro name='outer' params='x'><xacro:inner/></xacro:macro>"
                         "<xacro:outer x='1'/><xacro:outer x='2'/>"),
                   "<l v=\"1\"/><l v=\"2\"/>");
}

static void macros_have_defaults_and_blocks(void **state)
{
    (void)state;
    assert_expands(
        XACRO("<xacro:macro name='m' params=\"a b:=${1 + 1}  c:='' d:=^ e=^|'x y' f:=^|7\">"
              "<l v='${a}.${b}.${c}.${d}.${e}.${f}'/></xacro:macro>"
              "<xacro:property name='d' value='D'/><xacro:property name='f' value='F'/>"
              "<xacro:m a='A'/><xacro:m a='${[1]}' b='B' c='C' d='1' e='2' f='3'/>"),
        "<l v=\"A.2..D.x y.F\"/><l v=\"[1].B.C.1.2.3\"/>");
    assert_expands(
        XACRO(
            "<xacro:macro name='m' params='x *one **two'>"
            "<l><xacro:insert_block name='two'/><xacro:insert_block name='one'/></l></xacro:macro>"
            "<xacro:property name='x' value='0'/>"
            "<xacro:m x='1'><o v='${x}'/><xacro:if value='1'><t><p/><q/></t></xacro:if></xacro:m>"),
        "<l><p/><q/><o v=\"0\"/></l>");
    assert_expands(XACRO("<xacro:macro name='m' params='k'><l v='${k}'/>"
                         "<xacro:if value='${k &gt; 0}'><xacro:m k='${k - 1}'/></xacro:if>"
                         "</xacro:macro><xacro:call macro='${\"m\"}' k='2'/>"),
                   "<l v=\"2\"/><l v=\"1\"/><l v=\"0\"/>");
    assert_expands(XACRO("<xacro:macro name='m'><l/></xacro:macro>"
                         "<xacro:macro name='xacro:m'><n/></xacro:macro><xacro:m/>"),
                   "<n/>");
}

static void conditions_are_truth_values(void **state)
{
    (void)state;
    assert_expands(XACRO("<xacro:if value='true'><a/></xacro:if><xacro:if value='0'><b/></xacro:if>"
                         "<xacro:unless value='False'><c/></xacro:unless>"
                         "<xacro:if value='${[]}'><d/></xacro:if>"
                         "<xacro:if value=\"${'x' in 'xyz' and 0.0 == 0}\"><e/></xacro:if>"),
                   "<a/><c/><e/>");
    assert_xacro_refused(XACRO("<xacro:if value='1.0'/>"), NULL, "'1.0' is no truth value");
    assert_xacro_refused(XACRO("<xacro:if value='${\"x\"}'/>"), NULL, "no truth value");
}

static void arguments_come_from_the_caller_or_have_defaults(void **state)
{
    (void)state;
    static const char text[] =
        XACRO("<xacro:arg name='a' default='${1 + 1}'/>"
              "<xacro:arg name='b' default='no'/>"
              "<l v='$(arg a) $(arg b) ${$(arg a) * 2} ${xacro.arg(\"b\")}'/>");
    mbsr_file_opt opt = mbsr_default_file_opt();
    const mbsr_xacro_argument given[] = {{"b", "yes"}, {"c", "unused"}};
    assert_expands(text, "<l v=\"2 no 4 no\"/>");
    opt.xacro.arguments = 2;
    opt.xacro.argument = given;
    assert_expands_with(text, &opt, "<l v=\"2 yes 4 yes\"/>");
    /* of two to four bytes in UTF-8; half of a surrogate is none */
    const mbsr_xacro_argument wide = {"b", "K\xc3\xa4"
                                           "fer \xe2\x82\xac \xf0\x9f\x98\x80"};
    opt.xacro.arguments = 1;
    opt.xacro.argument = &wide;
    assert_expands_with(text, &opt,
                        "<l v=\"2 K\xc3\xa4"
                        "fer \xe2\x82\xac \xf0\x9f\x98\x80 4 K\xc3\xa4"
                        "fer \xe2\x82\xac \xf0\x9f\x98\x80\"/>");
    const mbsr_xacro_argument half = {"b", "\xed\xa0\x80"};
    opt.xacro.argument = &half;
    assert_xacro_refused(text, &opt, "characters that XML has not");
    assert_xacro_refused(XACRO("<l v='$(arg a)'/>"), NULL, "the argument 'a' has no value");
    assert_xacro_refused(XACRO("<xacro:arg name='a'/>"), NULL, "neither a value nor a default");
}

static void other_files_are_included(void **state)
{
    (void)state;
    static const other_file files[] = {
        {"arm/parts/a.xacro", XACRO("<xacro:include filename='b.xacro'/>"
                                    "<xacro:property name='p' value='1'/>"
                                    "<xacro:macro name='m'><l v='${p}'/></xacro:macro>")},
        {"arm/parts/b.xacro", XACRO("<b/>")},
        {"/ros/hand/c.xacro", XACRO("<c/>")},
        {"arm/n.yaml", "x: {y: 2}"},
        {"arm/inf.yaml", "[.inf, -.Inf, .NaN, 1_0.5]"},
        {"arm/odd.yaml", "a: \"\\q\""},
        {"other/d.xacro", XACRO("<d/>")},
        {NULL, NULL}};
    const mbsr_file_package packages[] = {{"hand", "/ros/hand/"}, {"up", "arm/../up"}};
    mbsr_file_opt opt = with_files(files);
    opt.packages = 2;
    opt.package = packages;
    assert_expands_with(XACRO("<xacro:include filename='parts/a.xacro'/><xacro:m/>"
                              "<xacro:include filename='./parts/../parts/b.xacro'/>"
                              "<xacro:include filename='$(find hand)/c.xacro'/>"
                              "<xacro:include filename='none.xacro' optional='true'/>"),
                        &opt, "<b/><l v=\"1\"/><b/><c/>");
    assert_expands_with(XACRO("<xacro:property name='p' value='0'/>"
                              "<xacro:include filename='parts/a.xacro' ns='n'/><xacro:n.m/>"
                              "<l v='${p} ${n.p}'/>"),
                        &opt, "<b/><l v=\"1\"/><l v=\"0 1\"/>");
    assert_expands_with(XACRO("<xacro:property name='f' value='${xacro.load_yaml(\"n.yaml\")}'/>"
                              "<l v='${f.x.y} ${f[\"x\"]} ${xacro.abs_filename(\"z\")}'/>"),
                        &opt, "<l v=\"2 {'y': 2} arm/z\"/>");
    assert_expands_with(XACRO("<xacro:property name='f' value='${load_yaml(\"inf.yaml\")}'/>"
                              "<l v='${f[0]} ${f[1]} ${f[2]} ${f[3]}'/>"),
                        &opt, "<l v=\"inf -inf nan 10.5\"/>");
    assert_xacro_refused(XACRO("<l v='${load_yaml(\"odd.yaml\")}'/>"), &opt,
                         "arm/odd.yaml:1: yaml: \\q in a text of YAML is not read");
    assert_xacro_refused(XACRO("<xacro:include filename='none.xacro'/>"), &opt,
                         "xacro:include: there is no file arm/none.xacro: No such file");
    assert_xacro_refused(XACRO("<xacro:include filename='parts/*.xacro'/>"), &opt, "several files");
    assert_xacro_refused(XACRO("<l v='$(find leg)'/>"), &opt, "where the package 'leg' is");
    static const char *const outside[] = {"../other/d.xacro",
                                          "parts/../../other/d.xacro",
                                          "/ros/hand/../d.xacro",
                                          "/ros/handle/c.xacro",
                                          "../armour/d.xacro",
                                          "..",
                                          "/"};
    for (size_t k = 0; k < sizeof outside / sizeof *outside; ++k) {
        char text[300];
        snprintf(text, sizeof text, XACRO("<xacro:include filename='%s'/>"), outside[k]);
        assert_xacro_refused(text, &opt, "neither in the model's folder nor in a package");
        snprintf(text, sizeof text, XACRO("<l v='${load_yaml(\"%s\")}'/>"), outside[k]);
        assert_xacro_refused(text, &opt, "neither in the model's folder nor in a package");
    }
    static const struct {
        const char *model, *path;
    } above[] = {{"../m.xacro", "../d.xacro"},
                 {"../../m.xacro", "../d.xacro"},
                 {"m.xacro", "../d.xacro"},
                 {"./a/../m.xacro", "../d.xacro"},
                 {"/a/m.xacro", "../d.xacro"}};
    for (size_t k = 0; k < sizeof above / sizeof *above; ++k) {
        char text[300];
        mbsr_written *written;
        mbsr_error error;
        snprintf(text, sizeof text, XACRO("<xacro:include filename='%s'/>"), above[k].path);
        assert_int_equal(
            mbsr_file_expand_xacro(text, strlen(text), above[k].model, &opt, &written, &error),
            MBSR_ERR_FILE);
        assert_contains(error.text, "neither in the model's folder nor in a package");
    }
    opt.xacro.outside = 1;
    assert_expands_with(XACRO("<xacro:include filename='../other/d.xacro'/>"), &opt, "<d/>");
}

static void meshes_are_found_in_packages(void **state)
{
    (void)state;
    static const char text[] = XACRO(
        "<link name='a'><visual><geometry><mesh filename='file://$(find hand)/m/a.stl'/></geometry>"
        "</visual></link>");
    mbsr_file_opt opt = mbsr_default_file_opt();
    opt.packages = 1;
    opt.package = &(mbsr_file_package){"hand", "/ros/hand/"};
    mbsr_file *file = read_small(text, &opt);
    assert_int_equal(file->shapes, 1);
    assert_string_equal(file->shape[0].mesh, "/ros/hand/m/a.stl");
    mbsr_file_destroy(file);
}

static void findings_and_errors_name_the_line_of_the_xacro(void **state)
{
    (void)state;
    static const other_file files[] = {
        {"arm/link.xacro", "<robot>\n<xacro:macro name='link' params='name mass'>\n"
                           "<link name='${name}'>\n<inertial>\n<mass value='${mass}'/>\n"
                           "</inertial></link>\n<link name='bare'/>\n</xacro:macro></robot>"},
        {"arm/n.yaml", "# two\na: 1\nb: |\n  text\n"},
        {NULL, NULL}};
    static const char joint[] =
        "<joint name='j' type='fixed'><parent link='a'/><child link='bare'/></joint>\n";
    mbsr_file_opt opt = with_files(files);
    mbsr_file *file;
    mbsr_error error;
    char text[600];
    snprintf(text, sizeof text,
             "<robot name='r' xmlns:xacro='u'>\n<xacro:include filename='link.xacro'/>\n"
             "<xacro:link name='a' mass='${1 + 1}'/>\n%s</robot>",
             joint);
    assert_ok(mbsr_file_read(text, strlen(text), "arm/small.xacro", &opt, &file, &error), &error);
    assert_int_equal(file->format, MBSR_FILE_URDF);
    assert_int_equal(file->bodies, 2);
    assert_int_equal(file->findings, 1);
    assert_string_equal(file->finding[0].file, "arm/link.xacro");
    assert_int_equal(file->finding[0].line, 7);
    assert_string_equal(file->finding[0].element, "link 'bare'");
    mbsr_file_destroy(file);
    snprintf(text, sizeof text,
             "<robot name='r' xmlns:xacro='u'>\n<xacro:include filename='link.xacro'/>\n"
             "<xacro:link name='a' mass='heavy'/>\n%s</robot>",
             joint);
    assert_int_equal(mbsr_file_read(text, strlen(text), "arm/small.xacro", &opt, &file, &error),
                     MBSR_ERR_FILE);
    assert_string_equal(error.text, "arm/link.xacro:3: link 'a': value=\"heavy\" is not 1 number");
    assert_xacro_refused("<robot xmlns:xacro='u'>\n<a>\n<b v='${c}'/></a></robot>", NULL,
                         "arm/small.xacro:3: b: there is no property or function 'c'");
    assert_xacro_refused(XACRO("<l v='${load_yaml(\"n.yaml\")}'/>"), &opt,
                         "arm/n.yaml:3: yaml: YAML with '|' is not read");
    /* attributes that xacro does not know are findings, which strict refuses */
    opt.strict = 1;
    assert_xacro_refused(XACRO("<xacro:property name='a' value='1' unit='m'/>"), &opt,
                         "xacro knows no attribute unit");
}

static void what_is_not_read_is_refused_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *inside, *words;
    } cases[] = {
        {"<l v='$(env HOME)'/>", "$(env HOME) is not read"},
        {"<l v='$(optenv HOME x)'/>", "$(optenv HOME x) is not read"},
        {"<l v='$(eval 1)'/>", "$(eval 1) is not read"},
        {"<l v='$(cwd)'/>", "$(cwd) is not read"},
        {"<l v='${1'/>", "'${1' is no text of xacro"},
        {"<l v='$(arg a'/>", "is no text of xacro"},
        {"<l v='$$a'/>", "is no text of xacro"},
        {"<xacro:element xacro:name='x'/>", "<xacro:element> is not read"},
        {"<l><xacro:attribute name='x' value='1'/></l>", "<xacro:attribute> is not read"},
        {"<xacro:gone/>", "there is no macro 'gone'"},
        {"<xacro:a.b/>", "there is no macro 'a.b'"},
        {"<xacro:call k='1'/>", "xacro:call: it has no macro"},
        {"<xacro:if/>", "xacro:if: it has no value"},
        {"<xacro:include/>", "it has no filename"},
        {"<xacro:insert_block name='b'/>", "xacro:insert_block 'b': there is no such block"},
        {"<xacro:macro params='a'/>", "it has no name"},
        {"<xacro:macro name='a.b'/>", "cannot have this name"},
        {"<xacro:macro name='m' params=\"a:='x\"/>", "a default of 'a' does not end"},
        {"<xacro:macro name='m' params='a'/><xacro:m/>", "the parameter 'a' is not given"},
        {"<xacro:macro name='m' params='a:=^'/><xacro:m/>", "the parameter 'a' is not given"},
        {"<xacro:macro name='m'/><xacro:m a='1'/>", "the macro has no parameter 'a'"},
        {"<xacro:macro name='m'/><xacro:m><b/></xacro:m>", "takes no block <b>"},
        {"<xacro:macro name='m' params='*b'/><xacro:m/>", "the block '*b' is missing"},
        {"<xacro:property value='1'/>", "it has no name"},
        {"<xacro:property name='a b' value='1'/>", "cannot be called 'a b'"},
        {"<xacro:property name='lambda' value='1'/>", "cannot be called 'lambda'"},
        {"<xacro:property name='__a' value='1'/>", "cannot be called '__a'"},
        {"<xacro:property name='a' value='1' default='2'/>", "exclude each other"},
        {"<xacro:property name='a' value='1' scope='parent'/>", "no scope around"},
        {"<xacro:property name='a' value='1' scope='moon'/>", "there is no scope 'moon'"},
        {"<xacro:property name='a' value='${b}'/><xacro:property name='b' value='${a}'/>"
         "<l v='${a}'/>",
         "the property 'a' depends on itself"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        char text[600];
        snprintf(text, sizeof text, XACRO("%s"), cases[k].inside);
        assert_xacro_refused(text, NULL, cases[k].words);
    }
    /* without the declaration nothing is expanded */
    assert_file_refused("<robot name='r'><xacro:macro name='m'/><link name='a'/></robot>", NULL,
                        "xmlns:xacro");
}

/* Texts, lists, macros and files that double themselves, or never end. */
static void expansions_are_bounded(void **state)
{
    (void)state;
    static const other_file files[] = {
        {"arm/self.xacro", XACRO("<xacro:include filename='self.xacro'/>")},
        {"arm/self.yaml", "a: !degrees load_yaml('self.yaml')"},
        {NULL, NULL}};
    const mbsr_file_opt opt = with_files(files);
    static const struct {
        const char *text, *words;
    } cases[] = {
        {XACRO("<xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/>"), "too deeply"},
        {XACRO("<xacro:macro name='m'><xacro:m/><xacro:m/></xacro:macro><xacro:m/>"), "too deeply"},
        {XACRO("<xacro:include filename='self.xacro'/>"), "too deeply"},
        {XACRO("<l v='${load_yaml(\"self.yaml\")}'/>"), "too deeply"},
        {XACRO("<l v='${\"a\" * 10000000}'/>"), "repeats too often"},
        {XACRO("<l v='${\"abcdefgh\" * 1000000}'/>"), "a text is too long"},
        {XACRO("<l v='${range(1000000000)}'/>"), "the expansion is too large"},
        {XACRO("<l v='${[0] * 1000000 * 1000000}'/>"), "the expansion is too large"},
        {XACRO("<xacro:macro name='m' params='a k'><xacro:if value='${k}'>"
               "<xacro:m a='${a + a}' k='${k - 1}'/></xacro:if></xacro:macro>"
               "<xacro:m a='laugh' k='40'/>"),
         "a text is too long"},
        {XACRO("<xacro:macro name='m' params='a k'><xacro:if value='${k}'>"
               "<xacro:m a='${[a, a]}' k='${k - 1}'/></xacro:if>"
               "<xacro:unless value='${k}'><l v='${a == [a, a]} ${len(str(a))}'/></xacro:unless>"
               "</xacro:macro><xacro:m a='x' k='60'/>"),
         "a text is too long"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k)
        assert_xacro_refused(cases[k].text, &opt, cases[k].words);
    /* 2^40 elements, or searches through a long text, by 40 macros */
    static const char *const inner[] = {"<l/>", "<xacro:if value='${\"c\" in long}'/>"};
    for (int kind = 0; kind < 2; ++kind) {
        char text[6000];
        snprintf(text, sizeof text,
                 "<robot xmlns:xacro='u'><xacro:property name='long' value='${\"ab\" * 500000}'/>"
                 "<xacro:macro name='m0'>%s</xacro:macro>",
                 inner[kind]);
        for (int k = 1; k <= 40; ++k) {
            const size_t used = strlen(text);
            snprintf(text + used, sizeof text - used,
                     "<xacro:macro name='m%d'><xacro:m%d/><xacro:m%d/></xacro:macro>", k, k - 1,
                     k - 1);
        }
        strcat(text, "<xacro:m40/></robot>");
        assert_xacro_refused(text, NULL, "the expansion is too large");
    }
    /* brackets in each other */
    char deep[4000] = "<robot xmlns:xacro='u'><l v='${";
    memset(deep + strlen(deep), '(', 3000);
    strcat(deep, "'/></robot>");
    assert_xacro_refused(deep, NULL, "no text of xacro");
    deep[3000] = '}';
    assert_xacro_refused(deep, NULL, "too deeply");
}

static void *scarce(void *user, size_t size)
{
    int *left = user;
    return (*left)-- > 0 ? malloc(size) : NULL;
}

static void give_back(void *user, void *memory)
{
    (void)user;
    free(memory);
}

static void lack_of_memory_is_told(void **state)
{
    (void)state;
    static const char text[] =
        XACRO("<xacro:macro name='m' params='k'><l v='${[k] * 1000}'/>"
              "<xacro:if value='${k}'><xacro:m k='${k - 1}'/></xacro:if></xacro:macro>"
              "<xacro:m k='20'/>");
    int status = MBSR_ERR_NO_MEMORY, allowed = 0;
    for (; status == MBSR_ERR_NO_MEMORY; ++allowed) {
        int left = allowed;
        mbsr_file_opt opt = mbsr_default_file_opt();
        mbsr_written *written;
        mbsr_error error;
        opt.model.allocator = (mbsr_allocator){scarce, give_back, &left};
        status = mbsr_file_expand_xacro(text, strlen(text), NULL, &opt, &written, &error);
        if (status) assert_null(written);
        mbsr_written_destroy(written);
    }
    assert_int_equal(status, MBSR_OK);
    assert_true(allowed > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(properties_are_evaluated_when_they_are_used),
        cmocka_unit_test(scopes_are_those_of_calls),
        cmocka_unit_test(macros_have_defaults_and_blocks),
        cmocka_unit_test(conditions_are_truth_values),
        cmocka_unit_test(arguments_come_from_the_caller_or_have_defaults),
        cmocka_unit_test(other_files_are_included),
        cmocka_unit_test(meshes_are_found_in_packages),
        cmocka_unit_test(findings_and_errors_name_the_line_of_the_xacro),
        cmocka_unit_test(what_is_not_read_is_refused_by_name),
        cmocka_unit_test(expansions_are_bounded),
        cmocka_unit_test(lack_of_memory_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
