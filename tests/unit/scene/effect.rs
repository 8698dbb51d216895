use super::*;
use enumset::EnumSet;

#[test]
fn an_id_is_the_name_in_json_and_leads_back_to_its_effect() {
    assert_eq!(Effect::RayVisibility.id(), "ray-visibility");
    assert_eq!(Effect::BaseColorTexture.to_string(), "base-color-texture");
    for effect in EnumSet::<Effect>::all() {
        assert_eq!(serde_json::to_value(effect).unwrap(), effect.id());
        assert_eq!(effect.id().parse(), Ok(effect));
    }
}
