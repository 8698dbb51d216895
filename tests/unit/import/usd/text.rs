use super::*;

fn read(text: &str) -> String {
    String::from_utf8(readable(text.as_bytes()).unwrap().text.into_owned()).unwrap()
}

#[test]
fn numbers_without_digits_on_a_side_get_them() {
    assert_eq!(
        read("float a = .5\nfloat3 b = (.1, -.2, 1.)\nfloat c = 2.e3 # .5"),
        "float a = 0.5\nfloat3 b = (0.1, -.2, 1.0)\nfloat c = 2.0e3 # .5"
    );
}

#[test]
fn strings_paths_and_comments_stay_as_they_are() {
    for text in [
        "string s = \"a .5 Vec3f b\"",
        "rel r = </A/B.c> /* .5 */",
        "asset a = @.5/Vec3f x.png@",
        "string s = '''Vec3f a\n.5'''",
        "def Point \"p\"\nfloat3 Color = (1, 2, 3)",
        "a.connect = <x>",
    ] {
        assert_eq!(read(text), text);
    }
}

/// Such names are looked for as variants without an end.
#[test]
fn names_with_brackets_are_refused() {
    for text in ["def \"a}b\" {\n}", "variantSet \"a{\" = {\n}"] {
        let told = readable(text.as_bytes()).unwrap_err();
        assert_eq!(told, "line 1: a name has a bracket in it");
    }
    let told = "string a = \"{}\"\ndef \"a\" (\n \"{}\"\n) {\n}";
    assert_eq!(read(told), told);
}

#[test]
fn old_types_get_their_new_names() {
    assert_eq!(
        read("uniform Vec3f[] a = []\nPointFloat[] points\nopaque outputs:x"),
        "uniform float3[] a = []\npoint3f[] points\ntoken outputs:x"
    );
}

#[test]
fn samples_of_paths_become_words() {
    assert_eq!(
        read("asset f.timeSamples = {\n 1: @a.png@,\n 2: @@,\n}\nasset g = @b.png@"),
        "asset f.timeSamples = {\n 1: \"a.png\",\n 2: \"\",\n}\nasset g = @b.png@"
    );
}

/// The parser reads samples of numbers without a look at their type.
#[test]
fn whole_numbers_over_time_are_of_the_attributes_type() {
    assert_eq!(
        read(
            "float a.timeSamples = {\n 1: 0, 2: None,\n 25: -180, 30: 1e3\n}\nint b.timeSamples = { 1: 0 }"
        ),
        "float a.timeSamples = {\n 1.0: 0.0, 2.0: None,\n 25.0: -180.0, 30.0: 1e3\n}\nint b.timeSamples = { 1: 0 }"
    );
    assert_eq!(
        read("double a = 1\nint b.timeSamples = { 1: 0 }"),
        "double a = 1\nint b.timeSamples = { 1: 0 }"
    );
}

#[test]
fn later_versions_are_read_as_the_first() {
    assert_eq!(read("#usda 1.2\n(\n)"), "#usda 1.0\n(\n)");
}

#[test]
fn what_ends_too_early_ends_there() {
    for text in ["\"abc", "@", "@@@", "<", "/*", "'''a''", "1.", "\"\\"] {
        let _ = read(text);
    }
}

#[test]
fn the_head_ends_where_prims_begin() {
    let of = |text: &'static str| head(text.as_bytes()).map(|h| std::str::from_utf8(h).unwrap());
    let fields =
        "#usda 1.0\n# )\n(\n doc = \"\"\"a ) b\"\"\"\n subLayers = [@a).usda@ (offset = 1)]\n)";
    let whole = format!("{fields}\ndef \"a\" (\n)\n{{}}\n").leak();
    assert_eq!(of(whole), Some(fields));
    assert_eq!(of("#usda 1.0\n\ndef \"a\" {}"), Some("#usda 1.0\n\n"));
    assert_eq!(of("#usda 1.0\n(\n"), None);
    assert_eq!(of("#usda 1.0\n)"), None);
    assert_eq!(of("#usda 1.0"), None);
}

/// The paths between the marks of this text have no end upwards in the parser's eyes.
#[test]
fn paths_without_a_root_are_refused() {
    let text = include_str!("../../../fuzz/found/path-without-a-root.usda");
    assert!(readable(text.as_bytes()).is_err());
    for path in [
        "",
        "/",
        "/a/b{c=d}e.f:g",
        "../a",
        "/a.b[/c.d].e",
        "/a.b c\nd.e",
    ] {
        let _ = has_a_root(path.as_bytes());
    }
    assert!(has_a_root(b"/World/mtl.outputs:surface") && has_a_root(b"../up.x"));
}

fn left_out(text: &str) -> Vec<(usize, String)> {
    let read = readable(text.as_bytes()).unwrap();
    let parts = read.left_out.into_iter();
    parts.map(|part| (part.line, part.what)).collect()
}

#[test]
fn files_in_quotes_become_paths() {
    assert_eq!(
        read("{\nasset a = \"x.png\"\nasset[] b = [\"y.png\", 'z.png']\nstring s = \"x\"\n}"),
        "{\nasset a = @x.png@\nasset[] b = [@y.png@, @z.png@]\nstring s = \"x\"\n}"
    );
    let words = "{\nasset a = @x@ (\nallowedTokens = [\"y\"]\n)\n}";
    assert_eq!(read(words), words);
}

#[test]
fn comments_by_two_strokes_are_taken_out() {
    assert_eq!(
        read("// a \"b\ndef \"x\" {\n// c\ndouble r = 1 // d\nstring s = \"// e\"\n}"),
        "\ndef \"x\" {\n\ndouble r = 1 \nstring s = \"// e\"\n}"
    );
}

#[test]
fn whole_numbers_lose_their_fraction() {
    assert_eq!(
        read("{\nint a = 5.0\nint[] b = [1.0, -2.5, 1e2]\nfloat c = 5.0\n}"),
        "{\nint a = 5\nint[] b = [1, -2, 100]\nfloat c = 5.0\n}"
    );
    let samples = "{\nint d.timeSamples = {\n0.5: 3\n}\n}";
    assert_eq!(read(samples), samples);
    assert_eq!(read("uint[] a = [1]"), "int64[] a = [1]");
    assert_eq!(read("uint a = 1"), "uint a = 1");
    assert_eq!(read("PointIndex[] a = [1]"), "int[] a = [1]");
}

#[test]
fn unknown_types_are_left_out_and_named() {
    let text = "{\ncustom vec3f[] a = [(1, 2, 3)] (\ndoc = \"}\"\n)\nfloat b = 1\nflaot c = 2\nfooType d\n}";
    assert_eq!(read(text), "{\n\nfloat b = 1\n\nfooType d\n}");
    assert_eq!(
        left_out(text),
        [(2, "custom vec3f[] a".into()), (6, "flaot c".into())]
    );
}

#[test]
fn words_of_old_are_dropped() {
    assert_eq!(
        read("{\nconfig token a = \"x\"\nvarying rel b = </c>\n}"),
        "{\n token a = \"x\"\n rel b = </c>\n}"
    );
    assert_eq!(
        read("def \"x\" (\nactive = False\n)\n{\ntoken outputs:s = </p.out>\nrel r = </p>\n}"),
        "def \"x\" (\nactive = false\n)\n{\ntoken outputs:s.connect = </p.out>\nrel r = </p>\n}"
    );
    let connected = "def \"x\" {\ntoken a.connect = </p.out>\n}";
    assert_eq!(read(connected), connected);
}

#[test]
fn fields_that_nobody_reads_do_no_harm() {
    let text = "def \"x\" (\nclipActive = [(101, 0)]\nprepend foo = [\"a\"]\nprepend references = @r.usda@\n)\n{\n}";
    assert_eq!(
        read(text),
        "def \"x\" (\n\n foo = [\"a\"]\nprepend references = @r.usda@\n)\n{\n}"
    );
    assert_eq!(left_out(text), [(2, "clipActive".into())]);
    assert_eq!(
        read("def \"x\" (\nfoo = @`\"./${X}.usda\"`@\n) {}"),
        "def \"x\" (\nfoo = '`\"./${X}.usda\"`'\n) {}"
    );
}

#[test]
fn marks_inside_of_long_strings_are_no_end() {
    assert_eq!(
        read("string a = \"\"\"x \\\"\"\" y\"\"\" float b"),
        "string a = \"\"\"x '\"\" y\"\"\" float b"
    );
    for text in ["\"\"\"\\", "\"\"\"\\\"", "'''\\''", "\"\"\"\\\"\"\""] {
        let _ = readable(text.as_bytes());
    }
}

#[test]
fn names_in_all_letters_are_told_apart_everywhere() {
    let new = "gr_xc3_xb6_xc3_x9fe";
    assert_eq!(
        read(
            "def \"größe\" {\nfloat2[] primvars:größe = []\nstring inputs:varname = \"größe\"\nfloat a.connect = </größe.primvars:größe>\n}"
        ),
        format!(
            "def \"größe\" {{\nfloat2[] primvars:{new} = []\nstring inputs:varname = \"{new}\"\nfloat a.connect = </größe.primvars:{new}>\n}}"
        )
    );
}

#[test]
fn arcs_to_classes_are_seen() {
    let arcs = |text: &str| readable(text.as_bytes()).unwrap().arcs;
    assert!(arcs("def \"x\" (\nprepend inherits = </c>\n) {}"));
    assert!(!arcs("def \"inherits\" (\nkind = \"specializes\"\n) {}"));
}

#[test]
fn three_marks_in_a_path_are_no_end() {
    let text = "{\nasset a = @@@x\\@@@y.png@@@\nfloat b = .5\n}";
    assert_eq!(read(text), "{\nasset a = @@\nfloat b = 0.5\n}");
    assert_eq!(left_out(text).len(), 1);
    let plain = "{\nasset a = @@@x@y.png@@@\n}";
    assert_eq!(read(plain), plain);
    let _ = readable(b"@@@\\@@@");
    let _ = readable(b"@@@\\@@@@@");
}

/// Each of these took a time that grows with the square of its length.
#[test]
fn long_texts_take_no_longer_than_they_are() {
    let start = std::time::Instant::now();
    for text in [
        format!("{{\n{}}}", "foo a = 1\n".repeat(200_000)),
        format!("{{{}}}", "foo a ".repeat(300_000)),
        format!("{{{}", "a[ ".repeat(500_000)),
    ] {
        let _ = readable(text.as_bytes());
        let mut left_out = Vec::new();
        let _ = super::super::repair::repaired(text.into_bytes().into(), &mut left_out);
    }
    // Seconds in a build that is not optimised; squares would be hours.
    assert!(start.elapsed().as_secs() < 120);
}
