use std::collections::HashMap;

use super::*;

struct Texts(HashMap<String, String>);

impl Layers for Texts {
    fn named(&self, asset: &str, _: &str) -> String {
        asset.to_owned()
    }

    fn parsed(&self, layer: &str) -> Option<Box<dyn AbstractData>> {
        parse(self.0.get(layer)?.as_bytes())
    }
}

/// Prims of the first layer's stack whose arcs are left out, and whether that is no loss.
fn found(layers: &[(&str, &str)]) -> Vec<(String, bool)> {
    let text = |text: &str| format!("#usda 1.0\n{text}");
    let texts = layers.iter().map(|(name, t)| ((*name).into(), text(t)));
    let dropped = tangled(&Texts(texts.collect()), layers[0].0);
    let told = dropped.into_iter();
    told.map(|d| (d.prim.to_string(), d.redundant)).collect()
}

const CLASS: &str = "class \"_c\" { def Xform \"r\" { def Sphere \"s\" {} } }\n";

#[test]
fn what_is_inherited_already_is_found() {
    let of = |rest: &str| found(&[("a", &format!("{CLASS}{rest}"))]);
    for arc in ["inherits", "specializes"] {
        assert_eq!(
            of(&format!(
                "def \"b\" ({arc} = </_c>) {{ over \"r\" ({arc} = </_c/r>) {{}} }}"
            )),
            [("/b/r".into(), true)]
        );
    }
    // By way of another class, and in a variant.
    assert_eq!(
        of(
            "class \"_d\" (inherits = </_c>) {}\ndef \"b\" (inherits = </_d>) { over \"r\" (inherits = </_c/r>) {} }"
        ),
        [("/b/r".into(), true)]
    );
    assert_eq!(
        of(
            "def \"b\" (inherits = </_c> prepend variantSets = \"v\") { variantSet \"v\" = { \"x\" { over \"r\" (inherits = </_c/r>) {} } } }"
        ),
        [("/b/r".into(), true)]
    );
    // Another prim of the class is no repetition.
    assert_eq!(
        of("def \"b\" (inherits = </_c>) { def \"q\" (inherits = </_c/r>) {} }"),
        []
    );
    assert_eq!(of("def \"b\" { over \"r\" (inherits = </_c/r>) {} }"), []);
}

#[test]
fn layers_are_looked_at_together() {
    let over = "( subLayers = [@b@] )\nover \"b\" { over \"r\" ( inherits = </_c/r> ) {} }";
    let below = format!("{CLASS}def \"b\" ( inherits = </_c> ) {{ }}");
    assert_eq!(
        found(&[("a", over), ("b", &below)]),
        [("/b/r".into(), true)]
    );
    let over = format!(
        "{CLASS}def \"q\" (references = @b@</b>) {{ over \"r\" (inherits = </_c/r>) {{}} }}"
    );
    assert_eq!(
        found(&[("a", &over), ("b", &below)]),
        [("/q/r".into(), true)]
    );
}

#[test]
fn circles_are_cut_once() {
    let count = |text: &str| found(&[("a", text)]).len();
    assert_eq!(count("def \"A\" (inherits = </A>) {}"), 1);
    assert_eq!(count("def \"A\" (inherits = </A/s>) { def \"s\" {} }"), 1);
    assert_eq!(
        count("def \"A\" (inherits = </B>) {} def \"B\" (inherits = </A>) {}"),
        1
    );
    assert_eq!(
        count(
            "def \"A\" (inherits = </B>) {} def \"B\" (inherits = </C>) {} def \"C\" (specializes = </A>) {}"
        ),
        1
    );
    assert_eq!(
        count(
            "class \"C\" { def \"x\" {} def \"y\" {} } def \"A\" (inherits = </C>) { over \"x\" (inherits = </C/y>) {} over \"y\" (inherits = </C/x>) {} }"
        ),
        1
    );
}

#[test]
fn layers_lose_those_arcs_alone() {
    let text = format!(
        "#usda 1.0\n{CLASS}def \"b\" (inherits = </_c>) {{ over \"r\" (prepend inherits = [</_c/r>, </_d>]) {{ double x = 1 }} }}"
    );
    let path = |path: &str| sdf::path(path).unwrap();
    let dropped = Dropped {
        layer: "a".into(),
        prim: path("/b/r"),
        target: path("/_c/r"),
        redundant: true,
    };
    let left = without(text.as_bytes(), &[dropped]).unwrap();
    let data = parse(&left).unwrap();
    let targets = |of: &str| list(&*data, &path(of), "inheritPaths").unwrap().flatten();
    assert_eq!(targets("/b/r"), [path("/_d")]);
    assert_eq!(targets("/b"), [path("/_c")]);
    assert!(data.has_spec(&path("/b/r.x")));
}
