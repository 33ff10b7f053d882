//! `murano bench stability`: hostile inputs keep their limits.

mod common;

use serde_json::Value;

/// Every group of the table has something to say about every method, every line holds, and no line holds for want of
/// pixels.
#[test]
fn hostile_inputs_are_bounded_or_flagged() {
    let (_keep, folder) = common::folder();
    let output = common::murano(&folder, &["bench", "stability", "--quick", "--json"]);
    let table: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    let rows = table["rows"].as_array().expect("a list of lines");
    assert!(rows.len() >= 50, "{} lines", rows.len());
    for row in rows {
        assert_eq!((&row["holds"], &row["non_finite"]), (&Value::from(true), &Value::from(0)), "{row:#}");
        assert!(row["pictures"].as_u64() > Some(0), "{row:#}");
        if !row["method"].is_null() {
            let seen = ["left", "reflected", "lost"].map(|status| row[status].as_u64().expect("a number"));
            assert!(seen.iter().sum::<u64>() > 0 && row["compared"].as_u64() > Some(0), "{row:#}");
        }
    }
    assert_eq!(output.status.code(), Some(0));
}
