//! `sundog selftest`: the hard cases on the user's own machine.

use super::args::SelfTest;
use super::exit::{EXIT_ERROR, EXIT_OK};
use super::{Failure, console};
use crate::report::{Cell, Column, Table};
use crate::selftest::{Case, Finding, GROUPS, Outcome};
use serde_json::{Value, json};

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

/// What has come of the cases so far.
struct Tally {
    table: Table,
    cases: Vec<Value>,
    failed: usize,
    seconds: f64,
}

impl Default for Tally {
    fn default() -> Self {
        let columns = ["case", "quantity", "expected", "found", "bound", "verdict"];
        Self {
            table: Table {
                columns: columns.map(Column::new).to_vec(),
                ..Table::default()
            },
            cases: Vec::new(),
            failed: 0,
            seconds: 0.0,
        }
    }
}

impl Tally {
    fn add(&mut self, group: &str, case: &Case, outcome: &Outcome) {
        let seconds = outcome.time.as_secs_f64();
        self.seconds += seconds;
        self.failed += usize::from(!outcome.holds());
        let mut told = json!({
            "group": group,
            "name": case.name,
            "about": case.about,
            "holds": outcome.holds(),
            "seconds": seconds,
        });
        match &outcome.findings {
            Ok(findings) => {
                let mut name = case.name;
                for finding in findings {
                    self.table.rows.push(row(name, finding));
                    name = "";
                }
                told["findings"] = json!(findings);
            }
            Err(error) => {
                let mut cells = [case.name, "", "", "", "", "error"].map(Cell::text);
                cells[1] = Cell::text(error.to_string());
                self.table.rows.push(cells.to_vec());
                told["error"] = json!(error.to_string());
            }
        }
        self.cases.push(told);
    }

    fn verdict(&self, cases: usize) -> String {
        let time = crate::math::words::duration(self.seconds);
        if self.failed == 0 {
            format!("\nAll of {cases} hard cases hold ({time}).\n")
        } else {
            let failed = self.failed;
            format!(
                "\n{failed} of {cases} hard cases do not hold ({time}): please report them with this table, `sundog --version` and the processor.\n"
            )
        }
    }
}

fn row(name: &str, finding: &Finding) -> Vec<Cell> {
    let verdict = match (finding.holds(), finding.place.as_str()) {
        (true, _) => "holds".into(),
        (false, "") => "FAILS".into(),
        (false, place) => format!("FAILS at {place}"),
    };
    vec![
        Cell::text(name),
        Cell::text(finding.quantity.as_str()),
        Cell::number(finding.expected),
        Cell::number(finding.found),
        Cell::number(finding.bound),
        Cell::text(verdict),
    ]
}
