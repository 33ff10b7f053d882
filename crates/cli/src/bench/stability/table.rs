//! The table: a line for each group and method, with its worst case.

use murano_metrics::report::{Column, Table};
use murano_refraction::Method;
use serde::Serialize;

use super::{
    case::{Group, Limits},
    measure::Outcome,
};

/// One line.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    group: &'static str,
    /// `None` where all methods are alike.
    method: Option<&'static str>,
    pictures: u32,
    /// Numbers that are NaN or infinite.
    non_finite: u64,
    /// Pixels that left, were totally reflected, were flagged.
    left: u64,
    reflected: u64,
    lost: u64,
    /// Pixels held against the truth.
    compared: u64,
    /// Of the case with the largest mean.
    mean_degrees: f64,
    p95_degrees: f64,
    max_degrees: f64,
    wrong: f64,
    flagged: f64,
    limits: Limits,
    /// Which cases were the worst, and what went wrong.
    worst: Vec<String>,
    holds: bool,
}

impl Row {
    /// Empty lines of a group, a method each.
    pub fn of_group(group: &Group) -> Vec<Self> {
        let row = |method: Method| Self {
            method: Some(method.name()),
            limits: group.limits.of(method),
            ..Self::empty(group.name)
        };
        Method::ALL.map(row).to_vec()
    }

    fn empty(group: &'static str) -> Self {
        Self {
            group,
            method: None,
            pictures: 0,
            non_finite: 0,
            left: 0,
            reflected: 0,
            lost: 0,
            compared: 0,
            mean_degrees: 0.0,
            p95_degrees: 0.0,
            max_degrees: 0.0,
            wrong: 0.0,
            flagged: 0.0,
            limits: Limits::NONE,
            worst: Vec::new(),
            holds: true,
        }
    }

    /// A line that holds or does not, without errors to measure.
    pub fn of_checks(group: &'static str, pictures: u32, problems: Vec<String>) -> Self {
        Self { pictures, holds: problems.is_empty(), worst: problems, ..Self::empty(group) }
    }

    /// Whether every case kept its limits.
    pub fn holds(&self) -> bool {
        self.holds
    }

    /// Takes in a case.
    pub fn add(&mut self, outcome: Outcome) {
        let (mean, wrong, flagged) = (outcome.mean_degrees(), outcome.wrong_share(), outcome.flagged_share());
        self.pictures += outcome.pictures;
        self.non_finite += outcome.non_finite;
        self.left += outcome.statuses[1];
        self.reflected += outcome.statuses[2];
        self.lost += outcome.statuses[3];
        self.compared += outcome.compared;
        let mut broken = Vec::new();
        broken.extend(outcome.finding.clone());
        if mean > self.limits.mean_degrees {
            broken.push(format!("mean error {mean:.4} degrees"));
        }
        if wrong > self.limits.wrong {
            broken.push(format!("{:.2} % of the pixels wrong", 100.0 * wrong));
        }
        if flagged > self.limits.flagged {
            broken.push(format!("{:.2} % of the pixels flagged", 100.0 * flagged));
        }
        self.holds &= broken.is_empty();
        if mean > self.mean_degrees {
            self.mean_degrees = mean;
            self.p95_degrees = outcome.quantile(0.95);
            self.max_degrees = outcome.quantile(1.0);
            self.name("angle", &outcome.label);
        }
        if wrong > self.wrong {
            self.wrong = wrong;
            self.name("status", &outcome.label);
        }
        if flagged > self.flagged {
            self.flagged = flagged;
            self.name("flagged", &outcome.label);
        }
        self.worst.extend(broken.into_iter().map(|what| format!("BROKEN {}: {what}", outcome.label)));
    }

    fn name(&mut self, what: &str, label: &str) {
        self.worst.retain(|worst| !worst.starts_with(what));
        self.worst.push(format!("{what}: {label}"));
    }
}

/// The table for people.
pub fn text(rows: &[Row]) -> String {
    let mut lines = Vec::new();
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = row.group;
            lines.push(String::new());
            lines.push(group.to_owned());
            if row.method.is_some() {
                lines.push(format!(
                    "  {:8} {:>8} {:>10} {:>9} {:>9} {:>8} {:>11} {:>9} {:>9} {:>8} {:>9}",
                    "method",
                    "pictures",
                    "non-finite",
                    "left",
                    "reflected",
                    "lost",
                    "mean deg",
                    "p95",
                    "max",
                    "wrong %",
                    "flagged %"
                ));
            }
        }
        let verdict = if row.holds { "" } else { "  BROKEN" };
        match row.method {
            Some(method) => lines.push(format!(
                "  {method:8} {:>8} {:>10} {:>9} {:>9} {:>8} {:>11.5} {:>9.4} {:>9.3} {:>8.2} {:>9.2}{verdict}",
                row.pictures,
                row.non_finite,
                row.left,
                row.reflected,
                row.lost,
                row.mean_degrees,
                row.p95_degrees,
                row.max_degrees,
                100.0 * row.wrong,
                100.0 * row.flagged,
            )),
            None => lines.push(format!("  {} checked{verdict}", row.pictures)),
        }
        lines.extend(row.worst.iter().map(|worst| format!("           {worst}")));
    }
    lines.join("\n")
}

/// The table for a page.
pub fn block(rows: &[Row]) -> Table {
    let number = Column::number;
    let columns = vec![
        Column::text("hostile input"),
        Column::text("method"),
        number("pictures"),
        number("non-finite"),
        number("mean °"),
        number("p95 °"),
        number("max °"),
        number("wrong %"),
        number("flagged %"),
        Column::text("worst cases"),
    ];
    let cells = |row: &Row| {
        let measured = |text: String| if row.method.is_some() { text } else { String::new() };
        vec![
            row.group.to_owned(),
            row.method.unwrap_or("all").to_owned(),
            row.pictures.to_string(),
            row.non_finite.to_string(),
            measured(format!("{:.4}", row.mean_degrees)),
            measured(format!("{:.3}", row.p95_degrees)),
            measured(format!("{:.2}", row.max_degrees)),
            measured(format!("{:.2}", 100.0 * row.wrong)),
            measured(format!("{:.2}", 100.0 * row.flagged)),
            row.worst.join("; "),
        ]
    };
    let caption = "The worst case of each group; wrong: another status than the truth's, unflagged".into();
    Table { caption, columns, rows: rows.iter().map(cells).collect() }
}

#[cfg(test)]
mod tests {
    use super::{super::case::MethodLimits, *};

    fn row() -> Row {
        let limits = MethodLimits::new([1.0, 0.1, 0.1], [0.5, 0.1, 0.2]);
        let rows = Row::of_group(&Group { name: "planted", limits, cases: Vec::new() });
        rows.into_iter().find(|row| row.method == Some("newton")).unwrap()
    }

    fn outcome() -> Outcome {
        Outcome { label: "case".into(), pictures: 1, compared: 10, degrees: vec![0.1, 0.3], ..Outcome::default() }
    }

    /// Each limit breaks the line, and the line says which case broke it.
    #[test]
    fn a_broken_limit_is_found_and_named() {
        for (planted, what) in [
            (Outcome { degrees: vec![0.5, 0.7], ..outcome() }, "mean error 0.6"),
            (Outcome { wrong: 2, ..outcome() }, "20.00 % of the pixels wrong"),
            (Outcome { flagged: 3, ..outcome() }, "30.00 % of the pixels flagged"),
            (Outcome { finding: Some("pass `x:0`".into()), non_finite: 1, ..outcome() }, "pass `x:0`"),
        ] {
            let mut row = row();
            row.add(outcome());
            assert!(row.holds());
            row.add(Outcome { label: "planted".into(), ..planted });
            row.add(outcome());
            assert!(
                !row.holds()
                    && row.worst.iter().any(|line| line.starts_with("BROKEN planted: ") && line.contains(what))
            );
            assert!(text(&[row]).contains("BROKEN planted"));
        }
    }

    #[test]
    fn the_worst_case_is_shown() {
        let mut row = row();
        row.add(Outcome { label: "bad".into(), degrees: vec![0.4], ..outcome() });
        row.add(outcome());
        assert_eq!((row.mean_degrees, row.max_degrees, row.pictures), (0.4, 0.4, 2));
        assert_eq!(row.worst, ["angle: bad"]);
    }
}
