//! What the command line says, in the words of a pipeline.

use crate::error::Error;
use crate::pipeline::options::Values;

/// An error that speaks of options of the command line, in the words of the stage of these values.
pub fn in_words_of(values: &Values, error: Error) -> Error {
    match error {
        Error::Input(mut fault) => {
            for name in ["overwrite", "resume"] {
                fault.remedy = fault.remedy.replace(&format!("--{name}"), &format!("the stage \"{name}\": true"));
            }
            if fault.place.is_empty() {
                fault.place.clone_from(&values.place().stage);
            }
            fault.into()
        }
        other => other,
    }
}
