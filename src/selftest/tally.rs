//! What has come of hard cases, as a table, for programs and in a sentence.

use super::{Case, Finding, Outcome};
use crate::report::{Cell, Column, Table};
use serde_json::{Value, json};

/// What has come of the cases so far.
pub struct Tally {
    /// A row for each finding.
    pub table: Table,
    /// The cases with their findings, for programs.
    pub cases: Vec<Value>,
    /// How many do not hold.
    pub failed: usize,
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
    /// Adds a case of a group.
    pub fn add(&mut self, group: &str, case: &Case, outcome: &Outcome) {
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

    /// All of it in a sentence.
    pub fn verdict(&self, cases: usize) -> String {
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
