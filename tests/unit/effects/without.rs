use super::*;
use crate::effects::sets;
use crate::scene::{AlphaMode, ImageId, MetallicRoughness};

#[test]
fn what_is_left_out_is_gone_and_the_rest_stays() {
    let glass = Material::from(MetallicRoughness {
        transmission: 1.0,
        thin_walled: false,
        roughness: 0.2,
        metallic: 0.5,
        alpha: 0.2,
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..MetallicRoughness::default()
    });
    assert_eq!(without_effects(&glass, sets::ALL), glass);
    let less =
        without_effects(&glass, sets::ALL - Effect::RoughGlass - Effect::AlphaClip).summary();
    let p = less.principled[0];
    assert_eq!(p.transmission.1, 0.0);
    assert_eq!(less.opacity, Opacity::Full);
    assert_eq!((p.metallic.1, p.specular.1), (0.5, 1.0));
    assert_eq!(
        without_effects(&glass, sets::ALL - Effect::ClearGlass),
        glass
    );
    let p = without_effects(&glass, EnumSet::empty())
        .summary()
        .principled[0];
    assert_eq!((p.metallic.1, p.specular.1), (0.0, 0.0));
}

#[test]
fn images_leave_their_factors_and_stay_where_they_are_called_for() {
    let image = Some(ImageId(0).into());
    let m = Material::from(MetallicRoughness {
        base_color: [0.5, 0.25, 1.0],
        base_color_texture: image.clone(),
        metallic: 0.75,
        metallic_roughness_texture: image,
        ..MetallicRoughness::default()
    });
    let plain = without_effects(&m, sets::ALL - Effect::MetallicRoughnessTexture);
    assert!(plain.graph.has_texture(Slot::BaseColor));
    assert!(!plain.graph.has_texture(Slot::MetallicRoughness));
    let p = plain.summary().principled[0];
    assert_eq!((p.metallic, p.roughness), ((0.75, 0.75), (1.0, 1.0)));
    let plain = without_effects(&m, sets::ALL - sets::TEXTURES);
    assert_eq!(plain.graph.textures().count(), 0);
    let base = plain.summary().principled[0].base_color;
    assert_eq!(base.to_array(), [0.5, 0.25, 1.0]);
}
