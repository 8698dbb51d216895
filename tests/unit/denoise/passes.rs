use super::*;

const LAYERS: [&str; 6] = [
    "Combined",
    "Depth",
    "DiffDir",
    "GlossInd",
    "Shadow Catcher",
    "Combined_key",
];

fn chosen(choice: &Choice) -> Result<Vec<&'static str>, String> {
    choice
        .of(LAYERS.into_iter())
        .map_err(|error| error.to_string())
}

#[test]
fn light_alone_is_chosen() {
    assert_eq!(chosen(&Choice::AsCycles).unwrap(), ["Shadow Catcher"]);
    let all = chosen(&"all".parse().unwrap()).unwrap();
    assert_eq!(
        all,
        ["DiffDir", "GlossInd", "Shadow Catcher", "Combined_key"]
    );
    let named = chosen(&"Combined_key, DiffDir".parse().unwrap()).unwrap();
    assert_eq!(named, ["DiffDir", "Shadow Catcher", "Combined_key"]);
}

#[test]
fn what_is_not_there_or_no_light_is_told_with_what_is() {
    for name in ["Depth", "VolumeDir", "Combined", "nonsense"] {
        let message = chosen(&name.parse().unwrap()).unwrap_err();
        assert!(message.contains(name), "{message}");
        assert!(
            message.contains("DiffDir, GlossInd, Shadow Catcher, Combined_key"),
            "{message}"
        );
    }
}

#[test]
fn colours_guide_what_has_them() {
    assert_eq!(albedo_in("DiffInd"), Some(Albedo::IsNotInIt));
    assert_eq!(albedo_in("TransInd"), Some(Albedo::IsInIt));
    assert_eq!(albedo_in("Combined_key"), Some(Albedo::IsInIt));
    for data in ["Combined", "DiffCol", "Normal", "CryptoObject00", "my AOV"] {
        assert_eq!(albedo_in(data), None);
    }
    assert_eq!(noisy_name("Shadow Catcher"), "Noisy Shadow Catcher");
}
