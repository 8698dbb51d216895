use super::*;
use clap::FromArgMatches;

fn parsed(arguments: &[&str]) -> Result<Command, clap::Error> {
    let all = std::iter::once("sundog").chain(arguments.iter().copied());
    let matches = program().try_get_matches_from(all)?;
    Ok(Program::from_arg_matches(&matches)?.command)
}

fn render(more: &[&str]) -> Render {
    match parsed(&[&["render", "a.glb", "-o", "b.exr"], more].concat()) {
        Ok(Command::Render(render)) => *render,
        other => panic!("{other:?}"),
    }
}

#[test]
fn clap_accepts_the_commands() {
    program().debug_assert();
}

#[test]
fn what_the_scene_may_decide_is_known_to_be_given_or_not() {
    let without = render(&[]);
    assert_eq!(without.effort.samples, None);
    assert_eq!(without.options.size.filter, None);
    assert_eq!(without.options.size.film_exposure, None);
    assert_eq!(without.view.seen.exposure, None);
    assert_eq!(render(&["--samples=256"]).effort.samples, Some(256));
}

/// What help shows as a default is a value, and for renders the library's own.
#[test]
fn presets_are_what_holds_without_the_flag() {
    fn presets(command: &clap::Command, check: &mut dyn FnMut(&str, &clap::Arg, &str)) {
        for arg in command.get_arguments() {
            if let Some(Preset(value)) = arg.get::<Preset>() {
                check(command.get_name(), arg, value);
            }
        }
        for inner in command.get_subcommands() {
            presets(inner, check);
        }
    }
    let mut seen = 0;
    presets(&program(), &mut |_, arg, value| {
        let text = format!("--{}={value}", arg.get_long().unwrap());
        let command = clap::Command::new("x").arg(arg.clone());
        command.try_get_matches_from(["x", &text]).unwrap();
        seen += 1;
    });
    assert!(seen > 10);
    let settings = crate::render::RenderSettings::default();
    let given = render(&[
        "--samples=256",
        "--film-exposure=1",
        "--filter=blackman-harris:1.5",
    ]);
    assert_eq!(given.effort.samples, Some(settings.samples));
    assert_eq!(
        given.options.size.film_exposure,
        Some(f64::from(settings.film_exposure))
    );
    assert_eq!(given.options.size.filter, Some(settings.filter));
}

#[test]
fn errors_are_one_line() {
    for (arguments, expected) in [
        (
            &["render", "a", "-o", "b", "--width", "0"][..],
            "--width cannot be '0': expected a whole number from 1 to 65536",
        ),
        (
            &["render", "a", "-o", "b", "--exposure", "x"],
            "--exposure cannot be 'x': expected a number from -32 to 32",
        ),
        (
            &["render", "a", "-o", "b", "--exr-type=double"],
            "--exr-type cannot be 'double': expected float or half",
        ),
        (
            &["render", "a", "-o", ""],
            "a value is required for '--output <FILE>' but none was supplied",
        ),
        (
            &["render", "a", "--exr-type"],
            "--exr-type cannot be '': expected float or half",
        ),
        (
            &["completions", "tcsh"],
            "SHELL cannot be 'tcsh': expected bash, elvish, fish, powershell or zsh",
        ),
        (
            &["render"],
            "the following required arguments were not provided: <SCENE>",
        ),
        (
            &["render", "a", "-o", "b", "--sample", "3"],
            "unexpected argument '--sample' found; a similar argument exists: '--samples'",
        ),
        (
            &["rendr"],
            "unrecognized subcommand 'rendr'; a similar subcommand exists: 'render'",
        ),
    ] {
        assert_eq!(sentence(&parsed(arguments).unwrap_err()), expected);
    }
}

#[test]
fn negative_numbers_are_values() {
    let given = render(&["--exposure", "-1.5", "--environment-rotation", "-90"]);
    assert_eq!(given.view.seen.exposure, Some(-1.5));
    assert_eq!(given.options.environment.environment_rotation, Some(-90.0));
}
