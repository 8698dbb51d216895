//! `sundog selftest`: the hard cases on the user's own machine.

use super::args::SelfTest;
use super::exit::{EXIT_ERROR, EXIT_OK};
use super::{Failure, console};
use crate::selftest::{Case, GROUPS, Tally};
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// A case that was asked for does not exist.
pub fn run(args: &SelfTest) -> Result<u8, Failure> {
    let cases = chosen(&args.case)?;
    if args.list {
        list(args.json, &cases);
        return Ok(EXIT_OK);
    }
    let mut told = Tally::default();
    for (group, case) in &cases {
        told.add(group, case, &case.outcome(args.effort));
    }
    if args.json {
        console::json_document(&json!({
            "holds": told.failed == 0,
            "cases": told.cases,
        }));
    } else {
        console::output(&told.table.text());
        console::output(&told.verdict(cases.len()));
    }
    Ok(if told.failed == 0 {
        EXIT_OK
    } else {
        EXIT_ERROR
    })
}

/// The cases with these names, each with its group; all if there are none.
fn chosen(names: &[String]) -> Result<Vec<(&'static str, &'static Case)>, Failure> {
    let all = GROUPS
        .iter()
        .flat_map(|group| group.cases.iter().map(|case| (group.name, case)));
    let all: Vec<_> = all.collect();
    let known = |name: &&String| all.iter().any(|(_, case)| case.name == **name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        return Err(Failure::usage(format!(
            "--case '{unknown}' is none of the hard cases; `sundog selftest --list` names them"
        )));
    }
    let wanted =
        |(_, case): &(_, &Case)| names.is_empty() || names.iter().any(|name| name == case.name);
    Ok(all.into_iter().filter(wanted).collect())
}

fn list(json: bool, cases: &[(&str, &Case)]) {
    if json {
        let of = |(group, case): &(&str, &Case)| json!({ "group": group, "name": case.name, "about": case.about });
        console::json_document(&cases.iter().map(of).collect::<Vec<_>>());
        return;
    }
    let mut last = "";
    for (group, case) in cases {
        if *group != last {
            console::output(&format!("{group}\n"));
            last = group;
        }
        console::output(&format!("  {}: {}\n", case.name, case.about));
    }
}
