use super::*;

#[test]
fn names_and_sets_say_the_same() {
    let list = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
    assert_eq!(parse(&list(&["alpha", "suns"])), Ok(ALPHA | Effect::Suns));
    assert_eq!(parse(&list(&["alpha-clip"])), Ok(Effect::AlphaClip.into()));
    assert_eq!(
        parse(&list(&["instances", "diffuse", "suns"])),
        Ok(Effect::Suns | Effect::Instances)
    );
    assert!(parse(&list(&["fog"])).unwrap_err().contains("rough-glass"));
    assert_eq!(names(ALPHA | Effect::Suns), ["alpha", "suns"]);
    assert_eq!(
        names(Effect::AlphaClip | Effect::PointLights),
        ["alpha-clip", "point-lights"]
    );
    assert_eq!(names(Effect::Suns | Effect::Diffuse), ["suns"]);
    for set in [
        ALL,
        PATHS,
        EnumSet::empty(),
        TEXTURES - Effect::VertexColors,
    ] {
        assert_eq!(parse(&names(set)), Ok(set));
    }
}
