/* Expressions of xacro give what those of Python give, and files of YAML what YAML 1.1 says.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "xacro_small.h"

#include <stdio.h>

/* The text of ${expression}. */
static void assert_value(const char *expression, const mbsr_file_opt *opt, const char *expected)
{
    char text[800], element[800];
    snprintf(text, sizeof text, XACRO("<l v=\"${%s}\"/>"), expression);
    snprintf(element, sizeof element, "<l v=\"%s\"/>", expected);
    assert_expands_with(text, opt, element);
}

static void assert_no_value(const char *expression, const mbsr_file_opt *opt, const char *words)
{
    char text[800];
    snprintf(text, sizeof text, XACRO("<l v=\"${%s}\"/>"), expression);
    assert_xacro_refused(text, opt, words);
}

typedef struct value_case {
    const char *expression, *expected;
} value_case;

static void assert_values(const value_case *cases, size_t count)
{
    for (size_t k = 0; k < count; ++k) assert_value(cases[k].expression, NULL, cases[k].expected);
}

static void assert_no_values(const value_case *cases, size_t count)
{
    for (size_t k = 0; k < count; ++k)
        assert_no_value(cases[k].expression, NULL, cases[k].expected);
}

static void numbers_are_written_with_the_fewest_digits(void **state)
{
    (void)state;
    static const value_case cases[] = {
        {"0.1 + 0.2", "0.30000000000000004"},
        {"1e16", "1e+16"},
        {"123456789012345.0", "123456789012345.0"},
        {"9999999999999998.0", "9999999999999998.0"},
        {"0.0001", "0.0001"},
        {"0.00001", "1e-05"},
        {"1.5e-7", "1.5e-07"},
        {"1e100", "1e+100"},
        {"-0.0", "-0.0"},
        {"100.0", "100.0"},
        {"5e-324", "5e-324"},
        {"2.5e-310", "2.5e-310"},
        {"1.7976931348623157e308", "1.7976931348623157e+308"},
        {"1/3", "0.3333333333333333"},
        {"0x1F + 0b101 + 0o17 + 1_000", "1051"},
        {".5 + 1.", "1.5"},
        {"0x_f_F + 1_0.2_5e0_1", "357.5"},
        {"inf", "inf"},
        {"-inf", "-inf"},
        {"nan", "nan"},
    };
    assert_values(cases, sizeof cases / sizeof *cases);
}

static void operators_are_those_of_python(void **state)
{
    (void)state;
    static const value_case cases[] = {
        {"1 + 2 * 3 - 4 / 2", "5.0"},
        {"7 // 2", "3"},
        {"-7 // 2", "-4"},
        {"-7 % 3", "2"},
        {"7 % -3", "-2"},
        {"7.5 // -2", "-4.0"},
        {"0.2 // 0.013", "15.0"},
        {"4.8999999999999995 // 0.7", "6.0"},
        {"-7.5 % 2", "0.5"},
        {"-2 ** 2", "-4"},
        {"2 ** 3 ** 2", "512"},
        {"2 ** -1", "0.5"},
        {"(-8.0) ** 3", "-512.0"},
        {"- - 3", "3"},
        {"True + 1", "2"},
        {"1 if 0.0 else 2 if '' else 3", "3"},
        {"1 and 0 or 'x'", "x"},
        {"not 1 == 2", "True"},
        {"1 &lt; 2 &lt;= 2 != 3 &gt; 1", "True"},
        {"1 &lt; 2 &gt; 2", "False"},
        {"0 and undefined", "0"},
        {"'a' &lt; 'b'", "True"},
        {"[1, 2] &lt; [1, 3]", "True"},
        {"1 == 1.0 == True", "True"},
        {"'1' == 1", "False"},
        {"None is None and True is not False", "True"},
        {"2 in [1, 2] and 'b' in 'abc' and 'z' not in dict(a=1)", "True"},
        {"'a' + 'b' * 3", "abbb"},
        {"'a' 'b'", "ab"},
        {"'it\\'s' + '\\\\'", "it's\\"},
        {"[1] + [2.0, 'x'] * 2", "[1, 2.0, 'x', 2.0, 'x']"},
        {"(1,) + (2,)", "(1, 2)"},
        {"1, 2", "(1, 2)"},
        {"()", "()"},
        {"[[1, 2], [3]][0][-1]", "2"},
        {"'abcdef'[1:-2] + 'abc'[2:] + 'abc'[:1] + 'abc'[-9:9]", "bcdcaabc"},
        {"[1, 2, 3][1:]", "[2, 3]"},
        {"xacro.dotify(dict(a=1, b=dict(c='x'))).b.c", "x"},
    };
    assert_values(cases, sizeof cases / sizeof *cases);
}

static void functions_are_those_that_xacro_offers(void **state)
{
    (void)state;
    static const value_case cases[] = {
        {"sin(pi / 6)", "0.49999999999999994"},
        {"math.atan2(1, -1)", "2.356194490192345"},
        {"radians(90)", "1.5707963267948966"},
        {"degrees(pi)", "180.0"},
        {"floor(-1.5) + ceil(1.2) + trunc(-1.7)", "-1"},
        {"log(8, 2)", "3.0"},
        {"hypot(3, 4) + fabs(-1) + sqrt(4)", "8.0"},
        {"tau / 2 == pi and isnan(nan) and isinf(inf) and not isfinite(inf)", "True"},
        {"int('12') + int(-2.7) + int(True)", "11"},
        {"float('1e3') + float(' -.5 ') + float(2)", "1001.5"},
        {"str(1.0) + str([1, 'a', None])", "1.0[1, 'a', None]"},
        {"len('abc') + len([1]) + len(dict(a=1))", "5"},
        {"list(range(3)) + list(range(5, 0, -2)) + list('ab')", "[0, 1, 2, 5, 3, 1, 'a', 'b']"},
        {"min(3, 1.5, 2)", "1.5"},
        {"max([1, 4, 2])", "4"},
        {"round(2.5) + round(3.5)", "6"},
        {"round(2.675, 2)", "2.67"},
        {"round(2.5, 0)", "2.0"},
        {"round(0.5)", "0"},
        {"sorted([3, 1, 2])", "[1, 2, 3]"},
        {"python.abs(-3) + python.sum([1, 2])", "6"},
        {"python.all([1, 2]) and not python.any([0, ''])", "True"},
        {"python.len('ab')", "2"},
        {"dict(a=1, b=[2])", "{'a': 1, 'b': [2]}"},
        {"list(dict(a=1, b=2).items())", "[('a', 1), ('b', 2)]"},
        {"dict(a=1).get('a') + dict(a=1).get('b', 2)", "3"},
        {"'Ab'.lower() + 'Ab'.upper() + ' x '.strip()", "abABx"},
        {"'a,b,,c'.split(',')", "['a', 'b', '', 'c']"},
        {"'  a b '.split()", "['a', 'b']"},
        {"'-'.join(['a', 'b']) + 'aXbX'.replace('X', 'yy')", "a-bayybyy"},
        {"'abc'.startswith('ab') and 'abc'.endswith('bc') and not 'c'.endswith('bc')", "True"},
        {"xacro.message('text') + 'x'", "x"},
        {"python.tuple([1, 'a']) + python.tuple()", "(1, 'a')"},
        {"dict(dict(a=1), b=2)", "{'a': 1, 'b': 2}"},
        {"python.abs(2) + python.abs(-1.5)", "3.5"},
        {"float('-inf') + float('.5e1')", "-inf"},
        {"None == None and dict(a=1) != dict(b=1) and dict(a=[1]) == dict(a=[1])", "True"},
    };
    assert_values(cases, sizeof cases / sizeof *cases);
}

/* What Python 3.11 prints of these. */
static void edges_are_those_of_python(void **state)
{
    (void)state;
    static const value_case cases[] = {
        {"0X1F + 0B11 + 0O17", "49"},
        {"1E2 + 1.5E+1", "115.0"},
        {"'a\\tb\\q'", "a&#9;b\\q"},
        {"(-9223372036854775807 - 1) // 2", "-4611686018427387904"},
        {"6.0 % -3.0", "-0.0"},
        {"0.0 // 5.0", "0.0"},
        {"-1.0 // 5.0", "-1.0"},
        {"3 * 'ab'", "ababab"},
        {"2 * [1] + (1 * [2])", "[1, 1, 2]"},
        {"'ab' * -1 + '' * 5", ""},
        {"[] * 3", "[]"},
        {"0 ** 0", "1"},
        {"0 * -3", "0"},
        {"-3 * -4 + -3 * 4", "0"},
        {"2 ** 62", "4611686018427387904"},
        {"log(1)", "0.0"},
        {"floor(3) + floor(True)", "4"},
        {"'abc'[1] + 'abc'[-1]", "bc"},
        {"[1, 2][1:0]", "[]"},
        {"(1, 2, 3)[:2]", "(1, 2)"},
        {"[1, 2][None:None]", "[1, 2]"},
        {"round(7)", "7"},
        {"round(1.5, 30)", "1.5"},
        {"round(1e300, 2)", "1e+300"},
        {"(1,) &lt; (2,)", "True"},
        {"(1, 2) == (1, 2) and [1] != (1,)", "True"},
        {"[1, [2]] == [1, [2.0]] and [1] != [1, 2]", "True"},
        {"None == 0 or True == None", "False"},
        {"'a' in ['b', 'a'] and 1 not in (2, 3)", "True"},
        {"1 if [] else 2 if None else 3 if () else 4", "4"},
        {"1 if 'x' else 2", "1"},
        {"not '' and not 0.0 and not nan == nan", "True"},
        {"str([&quot;a\\\\'b&quot;, 'c&quot;'])", "[&quot;a\\\\'b&quot;, 'c&quot;']"},
        {"str(dict(a=(1,), b=[], c=()))", "{'a': (1,), 'b': [], 'c': ()}"},
        {"1 &lt;= 1.0 and 2 &gt;= 2 and not 3 &lt; 3", "True"},
        {"'b' &gt; 'a' &gt;= 'a'", "True"},
        {"1e5 if 1 &lt; 2 else 0", "100000.0"},
        {"max('a', 'b') + min(['z', 'y'])", "by"},
        {"'a,b'.split(',')[1].replace('b', '')", ""},
        {"' '.join(['a']) + ''.join([])", "a"},
        {"'abc'.endswith('') and not 'a'.startswith('abc')", "True"},
        {"isfinite(1) and isinf(-inf) and isnan(nan)", "True"},
        {"str(True) + str(None) + str(2.0)", "TrueNone2.0"},
        {"float(True) + int(2)", "3.0"},
        {"1.5 == 1.5 != 2", "True"},
        {"- True + + 2", "1"},
        {"'x'.strip() + '  '.strip()", "x"},
        {"-0.0 // 1", "-0.0"},
        {"'ab'[0:2][1:]", "b"},
        {"'abc'[2:1]", ""},
    };
    assert_values(cases, sizeof cases / sizeof *cases);
}

/* An error in any part of an expression is that of the whole: each @ is one that divides by zero,
 * and then no value. */
static void errors_come_from_every_part(void **state)
{
    static const char *const whole[] = {"@ + 1",
                                        "1 + @",
                                        "-@",
                                        "not @",
                                        "@ ** 2",
                                        "2 ** @",
                                        "@ and 1",
                                        "1 and @",
                                        "@ or 1",
                                        "0 or @",
                                        "@ if 1 else 2",
                                        "1 if @ else 2",
                                        "1 if 0 else @",
                                        "@ &lt; 1",
                                        "1 &lt; @",
                                        "1 in @",
                                        "@ in [1]",
                                        "@ is None",
                                        "None is @",
                                        "[@]",
                                        "[1, @]",
                                        "(@, 1)",
                                        "(1, @)",
                                        "@, 1",
                                        "1, @",
                                        "[1][@]",
                                        "@[0]",
                                        "'ab'[@:]",
                                        "'ab'[:@]",
                                        "@[1:2]",
                                        "@.real",
                                        "sin(@)",
                                        "log(8, @)",
                                        "log(@, 2)",
                                        "hypot(1, @)",
                                        "hypot(@, 1)",
                                        "dict(a=@)",
                                        "dict(@)",
                                        "max(@)",
                                        "max(1, @)",
                                        "round(@)",
                                        "round(1.5, @)",
                                        "str(@)",
                                        "len(@)",
                                        "int(@)",
                                        "float(@)",
                                        "range(@)",
                                        "range(1, @)",
                                        "'a'.split(@)",
                                        "','.join(@)",
                                        "','.join([@])",
                                        "@ == 1",
                                        "1 != @",
                                        "sorted([1, @])",
                                        "python.sum([@])",
                                        "list(@)",
                                        "'a' + str(@)",
                                        "@ % 2",
                                        "3 // @",
                                        "[1, 2][@:][0]",
                                        "@(1)",
                                        "1 &lt; 2 &lt; @",
                                        "dict(a=1).get(@)"};
    char part[200];
    (void)state;
    for (size_t k = 0; k < sizeof whole / sizeof *whole; ++k) {
        const int before = (int)strcspn(whole[k], "@");
        const char *after = whole[k] + before + 1;
        snprintf(part, sizeof part, "%.*s(1 / 0)%s", before, whole[k], after);
        assert_no_value(part, NULL, "divides by zero");
        snprintf(part, sizeof part, "%.*s)%s", before, whole[k], after);
        assert_no_value(part, NULL, "expression");
        snprintf(part, sizeof part, "%.*s'%s", before, whole[k], after);
        assert_no_value(part, NULL, "");
    }
}

static void what_has_no_meaning_is_refused(void **state)
{
    (void)state;
    static const value_case cases[] = {
        {"", "'the end' where a value should be"},
        {"1 +", "'the end' where a value should be"},
        {"1 2", "where it should end"},
        {"(1", "',' is missing"},
        {"[1, 2", "',' is missing"},
        {"f(1", "',' is missing"},
        {"'a", "a string does not end"},
        {"01", "'01' is not read as a number"},
        {"1j", "'1j' is not read as a number"},
        {"9223372036854775808", "is not read as a number"},
        {"r'a'", "strings that begin with r'"},
        {"'\\x41'", "\\x in a string"},
        {"1 if 2", "'if' without 'else'"},
        {"1 not 2", "'not' behind a value"},
        {"lambda x: x", "'lambda'"},
        {"[x for x in 'ab']", "comprehensions"},
        {"1 | 2", "'| 2'"},
        {"~1", "'~1'"},
        {"a := 1", "where it should end"},
        {"1 / 0", "divides by zero"},
        {"1 // 0", "divides by zero"},
        {"1.5 % 0.0", "divides by zero"},
        {"0.0 ** -1", "divides by zero"},
        {"(-8.0) ** 0.5", "no finite number"},
        {"sqrt(-1)", "no finite number"},
        {"exp(1000)", "no finite number"},
        {"1e308 * 10", "no finite number"},
        {"2 ** 63", "beyond 64 bits"},
        {"9223372036854775807 + 1", "beyond 64 bits"},
        {"-9223372036854775807 - 2", "beyond 64 bits"},
        {"4611686018427387904 * -4", "beyond 64 bits"},
        {"int(1e30)", "beyond 64 bits"},
        {"'a' + 1", "a string + a number has no meaning"},
        {"'%s' % 1", "formatting by %"},
        {"1 &lt; 'a'", "a number and a string have no order"},
        {"nan &lt; 1", "nan has no order"},
        {"-'a'", "a string has no sign"},
        {"1 in 2", "a number cannot be in a number"},
        {"1 is 1", "'is' is read for"},
        {"[1][1]", "an index is 1, of 1"},
        {"[1]['a']", "an index is a string"},
        {"dict(a=1)['b']", "no key 'b'"},
        {"dict(a=1).b", "no key 'b'"},
        {"1 .a", "a number has no 'a'"},
        {"math.len", "a module has no 'len'"},
        {"undefined", "no property or function 'undefined'"},
        {"abs(1)", "no property or function 'abs'"},
        {"__import__('os')", "no property or function '__import__'"},
        {"open('/etc/passwd')", "no property or function 'open'"},
        {"''.__class__", "a string has no '__class__'"},
        {"1(2)", "a number is called"},
        {"sin()", "sin() is given 0 arguments"},
        {"sin('a')", "sin() is given a string"},
        {"int('a')", "int() is given 'a'"},
        {"round(x=1)", "round() is given 'x' by name"},
        {"str(sin)", "a function cannot be written"},
        {"math", "a module cannot be written"},
        {"xacro.fatal('stop')", "stop"},
        {"range(1, 2, 0)", "steps of 0"},
        {"min([])", "min() of nothing"},
        {"float('1x')", "float() is given '1x'"},
        {"float([1])", "float() is given a list"},
        {"int([1])", "int() is given a list"},
        {"len(1)", "len() is given a number"},
        {"python.abs('a')", "abs() is given a string"},
        {"round('a')", "round() is given a string"},
        {"round(1.5, 'a')", "round() is given a string"},
        {"round(15.0, -1)", "digits behind a point only"},
        {"dict(1)", "dict() is given a number"},
        {"dict(a=1, a=2)", "dict() has 'a' twice"},
        {"sin == sin", "a function cannot be compared"},
        {"0x", "'0x' is not read as a number"},
        {"0xg", "is not read as a number"},
        {"0b2", "is not read as a number"},
        {"1__0", "is not read as a number"},
        {"1_", "is not read as a number"},
        {"0x_", "is not read as a number"},
        {"1_.5", "is not read as a number"},
        {"1e", "is not read as a number"},
        {"1..2", "number"},
        {"0x8000000000000000", "is not read as a number"},
        {"5 - (-9223372036854775807 - 1)", "beyond 64 bits"},
        {"(-9223372036854775807 - 1) // -1", "beyond 64 bits"},
        {"(-9223372036854775807 - 1) * -1", "beyond 64 bits"},
        {"(-9223372036854775807 - 1) * 2", "beyond 64 bits"},
        {"10 ** 40", "beyond 64 bits"},
        {"'a' * 'b'", "has no meaning"},
        {"1.5 * [1]", "has no meaning"},
        {"[1] + (1,)", "has no meaning"},
        {"'a' - 'b'", "has no meaning"},
        {"None + None", "has no meaning"},
        {"log(2, 1)", "divides by zero"},
        {"log('a')", "log() is given a string"},
        {"log(2, 'a')", "log() is given a string"},
        {"log(0)", "no finite number"},
        {"atan2('a', 1)", "atan2() is given a string"},
        {"atan2(1, 'a')", "atan2() is given a string"},
        {"isnan('a')", "isnan() is given a string"},
        {"floor('a')", "floor() is given a string"},
        {"'ab'['a']", "an index is a string"},
        {"'ab'[5]", "an index is 5, of 2"},
        {"[1]['a':]", "an index is a string"},
        {"(1)[0]", "a number"},
        {"1[1:]", "a number"},
        {"min(1, 'a')", "no order"},
        {"sorted([1, 'a'])", "no order"},
        {"sorted(1)", "sorted() is given a number"},
        {"python.sum(['a', 1])", "has no meaning"},
        {"python.sum(1)", "sum() is given a number"},
        {"python.any(1)", "any() is given a number"},
        {"python.tuple(1)", "tuple() is given a number"},
        {"list(1)", "list() is given a number"},
        {"range('a')", "range() is given a string"},
        {"range(99999999999)", "too long"},
        {"range(1.5)", "range() is given a number"},
        {"'a'.startswith(1)", "startswith() is given a number"},
        {"'a'.split(1)", "split() is given a number"},
        {"'a'.split('')", "split() at nothing"},
        {"'-'.join(1)", "join() is given a number"},
        {"'-'.join([1])", "join() is given a number"},
        {"'a'.replace(1, 'b')", "replace() is given a number"},
        {"'a'.replace('a', 1)", "replace() is given a number"},
        {"load_yaml(1)", "load_yaml() is given a number"},
        {"xacro.arg(1)", "arg() is given a number"},
        {"xacro.arg('none')", "the argument 'none' has no value"},
        {"xacro.dotify(1)", "dotify() is given a number"},
        {"xacro.message(sin)", "a function cannot be written"},
        {"xacro.fatal(sin)", "a function cannot be written"},
        {"round(1.5, 0.5)", "round() is given a number"},
        {"dict(dict(a=1), dict(b=2))", "dict() is given"},
        {"'&#228;b'[0]", "beyond ASCII"},
        {"None &lt; None", "have no order"},
        {"{'a': 1}", "is nothing that expressions have"},
        {"1 is not 1", "'is' is read for"},
        {"a[1:2:3]", "']' is missing"},
        {"sin(1, 2)", "sin() is given 2 arguments"},
        {"'a' 'b", "a string does not end"},
        {"1 ? 2", "'? 2'"},
    };
    assert_no_values(cases, sizeof cases / sizeof *cases);
}

static void yaml_is_read_as_its_version_1_1_says(void **state)
{
    (void)state;
    static const char text[] = "# a comment\n"
                               "---\n"
                               "map:\n"
                               "  whole: -12   # another\n"
                               "  real: 1.5e-3\n"
                               "  no_real: 1e5\n"
                               "  text: a b:c #d\n"
                               "  yes: Yes\n"
                               "  empty:\n"
                               "  'quoted ''key''': \"x\\t\\\"y\\\"\"\n"
                               "list:\n"
                               "- 1\n"
                               "-   a: 2\n"
                               "    b: [3, {c: 4, 'd': [5]},\n"
                               "        6.]\n"
                               "- - 7\n"
                               "  - ~\n"
                               "angles: {a: !degrees 180, b: !radians pi/2, c: !inches 10}\n"
                               "first: &it\n"
                               "  x: 1\n"
                               "second: *it\n"
                               "2: two\r\n";
    const other_file files[] = {{"arm/y.yaml", text}, {NULL, NULL}};
    mbsr_file_opt opt = with_files(files);
    assert_value("load_yaml('y.yaml').map", &opt,
                 "{'whole': -12, 'real': 0.0015, 'no_real': '1e5', 'text': 'a b:c', True: True, "
                 "'empty': None, &quot;quoted 'key'&quot;: 'x\\t&quot;y&quot;'}");
    assert_value("load_yaml('y.yaml')['list']", &opt,
                 "[1, {'a': 2, 'b': [3, {'c': 4, 'd': [5]}, 6.0]}, [7, None]]");
    assert_value("list(load_yaml('y.yaml').angles.values())", &opt,
                 "[3.141592653589793, 1.5707963267948966, 0.254]");
    assert_value("load_yaml('y.yaml').second.x + len(load_yaml('y.yaml')[2])", &opt, "4");
}

/* Scalars, and what PyYAML 6.0.3 makes of them; quotes as they stand in attributes. */
static const value_case scalars[] = {
    {"[1]", "[1]"},
    {"[+1]", "[1]"},
    {"[-1]", "[-1]"},
    {"[0]", "[0]"},
    {"[-0]", "[0]"},
    {"[+0]", "[0]"},
    {"[0o10]", "['0o10']"},
    {"[0X1F]", "['0X1F']"},
    {"[1_000]", "[1000]"},
    {"[_1]", "['_1']"},
    {"[1_]", "[1]"},
    {"[12e3]", "['12e3']"},
    {"[1.2e3]", "['1.2e3']"},
    {"[1.2e+3]", "[1200.0]"},
    {"[1.2E-3]", "[0.0012]"},
    {"[1e+3]", "['1e+3']"},
    {"[1.e+3]", "[1000.0]"},
    {"[.5]", "[0.5]"},
    {"[.5e+1]", "[5.0]"},
    {"[-.5]", "['-.5']"},
    {"[+.5]", "['+.5']"},
    {"[.]", "['.']"},
    {"[.e+1]", "['.e+1']"},
    {"[-.]", "['-.']"},
    {"[+.inf]", "[inf]"},
    {"[-.INF]", "[-inf]"},
    {"[.Inf]", "[inf]"},
    {"[.iNF]", "['.iNF']"},
    {"[.nan]", "[nan]"},
    {"[.NAN]", "[nan]"},
    {"[.NaN]", "[nan]"},
    {"[.Nan]", "['.Nan']"},
    {"[~]", "[None]"},
    {"[null]", "[None]"},
    {"[Null]", "[None]"},
    {"[NULL]", "[None]"},
    {"[nULL]", "['nULL']"},
    {"[nul]", "['nul']"},
    {"[yes]", "[True]"},
    {"[Yes]", "[True]"},
    {"[YES]", "[True]"},
    {"[yEs]", "['yEs']"},
    {"[no]", "[False]"},
    {"[No]", "[False]"},
    {"[NO]", "[False]"},
    {"[on]", "[True]"},
    {"[On]", "[True]"},
    {"[ON]", "[True]"},
    {"[off]", "[False]"},
    {"[Off]", "[False]"},
    {"[OFF]", "[False]"},
    {"[true]", "[True]"},
    {"[True]", "[True]"},
    {"[TRUE]", "[True]"},
    {"[tRUE]", "['tRUE']"},
    {"[false]", "[False]"},
    {"[False]", "[False]"},
    {"[FALSE]", "[False]"},
    {"[y]", "['y']"},
    {"[n]", "['n']"},
    {"[Y]", "['Y']"},
    {"[N]", "['N']"},
    {"[1.5.2]", "['1.5.2']"},
    {"[1-2]", "['1-2']"},
    {"[--1]", "['--1']"},
    {"[+-1]", "['+-1']"},
    {"[++1]", "['++1']"},
    {"[1e5]", "['1e5']"},
    {"[1E+5]", "['1E+5']"},
    {"[1.0e5]", "['1.0e5']"},
    {"[1__0]", "[10]"},
    {"[1_.5]", "[1.5]"},
    {"[1._5]", "[1.5]"},
    {"[1.5_]", "[1.5]"},
    {"[0.1_2]", "[0.12]"},
    {"[.1_2]", "[0.12]"},
    {"[09.5]", "[9.5]"},
    {"[1,2]", "[1, 2]"},
    {"[abc]", "['abc']"},
    {"[a_b]", "['a_b']"},
    {"[a-b]", "['a-b']"},
    {"[-a]", "['-a']"},
    {"[+a]", "['+a']"},
    {"['quo''ted']", "[&quot;quo'ted&quot;]"},
    {"[\"dou\\tble\"]", "['dou\\tble']"},
    {"['true']", "['true']"},
    {"[\"1\"]", "['1']"},
    {"[0.0]", "[0.0]"},
    {"[-0.0]", "[-0.0]"},
    {"[123456789012]", "[123456789012]"},
    {"[0.1]", "[0.1]"},
    {"[1.7976931348623157e+308]", "[1.7976931348623157e+308]"},
    {"[1e999]", "['1e999']"},
    {"[4.9e-324]", "[5e-324]"},
};

static void scalars_are_what_python_reads(void **state)
{
    static const char *const odd[] = {
        "[+0b101]", "[-0x1f]", "[-1:30.5]", "[00]",    "[007]",    "[01]",
        "[010]",    "[08]",    "[0_1]",     "[0b]",    "[0b102]",  "[0b1_0]",
        "[0x]",     "[0x1F]",  "[0x1_F]",   "[0x_1F]", "[12:30.]", "[190:20:30.15]",
        "[1:30]",   "[1:305]", "[1:30:45]", "[1:5:7]", "[1:60]"};
    (void)state;
    for (size_t k = 0; k < sizeof scalars / sizeof *scalars; ++k) {
        const other_file files[] = {{"arm/y.yaml", scalars[k].expression}, {NULL, NULL}};
        const mbsr_file_opt opt = with_files(files);
        assert_value("load_yaml('y.yaml')", &opt, scalars[k].expected);
    }
    for (size_t k = 0; k < sizeof odd / sizeof *odd; ++k) {
        const other_file files[] = {{"arm/y.yaml", odd[k]}, {NULL, NULL}};
        const mbsr_file_opt opt = with_files(files);
        assert_no_value("load_yaml('y.yaml')", &opt, "is a date, or no decimal number");
    }
    const other_file files[] = {{"arm/y.yaml", "[-100_000_000_000_000_000_000]"}, {NULL, NULL}};
    const mbsr_file_opt opt = with_files(files);
    assert_no_value("load_yaml('y.yaml')", &opt, "is not read as a number");
}

/* Texts as numbers, and what Python 3.11 makes of them; NULL: it refuses, as is refused here what
 * has underscores in a real number or is too large. */
static const value_case texts[] = {
    {"int('1')", "1"},
    {"int(' 12 ')", "12"},
    {"int('1_000')", "1000"},
    {"int('1__0')", NULL},
    {"int('_1')", NULL},
    {"int('1_')", NULL},
    {"int('+5')", "5"},
    {"int('-5')", "-5"},
    {"int('--5')", NULL},
    {"int('+ 5')", NULL},
    {"int('0x10')", NULL},
    {"int('1e3')", NULL},
    {"int('1.0')", NULL},
    {"int('')", NULL},
    {"int('  ')", NULL},
    {"int('9223372036854775807')", "9223372036854775807"},
    {"int('inf')", NULL},
    {"int('00')", "0"},
    {"int('-0')", "0"},
    {"int('1_0_0')", "100"},
    {"float('1')", "1.0"},
    {"float(' 1.5 ')", "1.5"},
    {"float('1_0.5')", NULL},
    {"float('1_000e1_0')", NULL},
    {"float('1__0.0')", NULL},
    {"float('_1.0')", NULL},
    {"float('1_.0')", NULL},
    {"float('1._0')", NULL},
    {"float('.5')", "0.5"},
    {"float('5.')", "5.0"},
    {"float('-.5e-3')", "-0.0005"},
    {"float('e5')", NULL},
    {"float('1e')", NULL},
    {"float('1e+')", NULL},
    {"float('inf')", "inf"},
    {"float('-inf')", "-inf"},
    {"float('+Infinity')", "inf"},
    {"float('INFINITY')", "inf"},
    {"float('nan')", "nan"},
    {"float('NaN')", "nan"},
    {"float('infin')", NULL},
    {"float('0x1')", NULL},
    {"float('1,5')", NULL},
    {"float('')", NULL},
    {"float('-0.0')", "-0.0"},
    {"float('1e400')", NULL},
    {"float('1e-400')", "0.0"},
    {"float('1.5e 3')", NULL},
};

static void texts_become_the_numbers_of_python(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k) {
        if (texts[k].expected)
            assert_value(texts[k].expression, NULL, texts[k].expected);
        else
            assert_no_value(texts[k].expression, NULL, "");
    }
}

static void other_yaml_is_refused_with_its_line(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"a: |\n  x\n", "y.yaml:1: yaml: YAML with '|'"},
        {"a: >\n  x\n", "YAML with '>'"},
        {"\n? a\n: b\n", "y.yaml:2: yaml: "},
        {"a: &x 1\n<<: *x\n", "YAML with '<<'"},
        {"a: *x\n", "no anchor '&x'"},
        {"a: !!float 1\n", "the tag !!float of YAML is not read"},
        {"a: !degrees up\n", "no property or function 'up'"},
        {"a: !degrees [1]\n", "!degrees is given [1"},
        {"a: 0x10\n", "'0x10' is a date, or no decimal number"},
        {"a: 010\n", "'010' is a date, or no decimal number"},
        {"a: 1:30\n", "'1:30' is a date, or no decimal number"},
        {"a: 2020-01-02\n", "is a date"},
        {"a: 'x\n  y'\n", "a text does not end in its line"},
        {"a: x\n  y\n", "y.yaml:2: yaml: 'y' does not belong"},
        {"a: b: c\n", "behind a key in its line"},
        {"a: - b\n", "behind a key in its line"},
        {"a: [1, 2\n", "do not end, or lack ','"},
        {"a: [1] 2\n", "'2' stands behind a value"},
        {"a:\n   b: 1\n  c: 2\n", "y.yaml:3: yaml: 'c: 2' does not belong"},
        {"a: 1\nb\n", "'b' is no key"},
        {"a:\n\t- 1\n", "a tab stands between words"},
        {"%YAML 1.1\n", "YAML with '%'"},
        {"a: 1\n---\nb: 2\n", "'---' is no key"},
        {"{a 1}", "a key in braces has no ':'"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        const other_file files[] = {{"arm/y.yaml", cases[k].text}, {NULL, NULL}};
        mbsr_file_opt opt = with_files(files);
        assert_no_value("load_yaml('y.yaml')", &opt, cases[k].words);
    }
    /* a key that is there twice is told, and its last value counts */
    const other_file files[] = {{"arm/y.yaml", "a: 1\nb: 2\na: 3\n"}, {NULL, NULL}};
    mbsr_file_opt opt = with_files(files);
    assert_value("load_yaml('y.yaml')", &opt, "{'a': 3, 'b': 2}");
    opt.strict = 1;
    assert_no_value("load_yaml('y.yaml')", &opt, "y.yaml:3: yaml: a key is there twice");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_written_with_the_fewest_digits),
        cmocka_unit_test(operators_are_those_of_python),
        cmocka_unit_test(functions_are_those_that_xacro_offers),
        cmocka_unit_test(edges_are_those_of_python),
        cmocka_unit_test(errors_come_from_every_part),
        cmocka_unit_test(what_has_no_meaning_is_refused),
        cmocka_unit_test(yaml_is_read_as_its_version_1_1_says),
        cmocka_unit_test(other_yaml_is_refused_with_its_line),
        cmocka_unit_test(scalars_are_what_python_reads),
        cmocka_unit_test(texts_become_the_numbers_of_python),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
