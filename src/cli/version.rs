//! `gable --version`: what this build is made of, for whoever reports a fault.

use crate::network::Field;
use crate::source::crs;

/// The version, and below it what may differ between two builds of it.
pub(super) fn long() -> String {
    format!(
        "{}\nsystem  {} {}\nPROJ    {}\nfields  {}{}{}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::ARCH,
        std::env::consts::OS,
        crs::proj_version(),
        Field::built_in().iter().map(|field| field.name()).collect::<Vec<_>>().join(", "),
        if cfg!(feature = "pipelines") { "" } else { "\nwithout pipelines" },
        if cfg!(feature = "remote") { "" } else { "\nwithout object storage" }
    )
}
