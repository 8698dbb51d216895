use super::*;

fn read(text: &str) -> String {
    String::from_utf8(readable(text.as_bytes()).unwrap().into_owned()).unwrap()
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
