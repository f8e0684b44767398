//! The schema of plans.

use std::path::Path;

use super::*;

#[test]
fn the_checked_in_schema_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/plan.schema.json");
    if std::env::var_os("GABLE_UPDATE_SCHEMAS").is_some() {
        std::fs::write(&path, schema()).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == schema(),
        "{} is stale: renew it with `GABLE_UPDATE_SCHEMAS=1 cargo test --release --lib up_to_date`",
        path.display()
    );
}
