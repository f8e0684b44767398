//! Parameters as flags, made from the structures that hold them.
//!
//! A new field of a [`Tunable`] structure becomes a flag without a line here: its name is the flag, its documentation the
//! help, its default the default, its type and range decide what is accepted.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use serde_json::Value;

use crate::pipeline::options::{Kind, Tunable, Tuning, tuned, tunings};

/// The fields of a structure as flags.
#[derive(Debug, Clone, Default)]
pub struct Flags<T>(pub T);

/// How a field is called on the command line.
fn flag(tuning: &Tuning) -> String {
    tuning.name.replace('_', "-")
}

/// Reads the value of a flag.
fn parser(kind: Kind) -> ValueParser {
    match kind {
        Kind::Choice(names) => {
            let values = names.into_iter().map(|(name, help)| PossibleValue::new(name).help(help));
            PossibleValuesParser::new(values).map(Value::String).into()
        }
        Kind::Boolean => ValueParser::from(clap::builder::BoolValueParser::new().map(Value::Bool)),
        kind => ValueParser::new(move |text: &str| {
            let value = kind.accept(&Value::String(text.to_owned()));
            value.ok_or_else(|| format!("{} is expected", kind.expected()))
        }),
    }
}

impl<T: Tunable> clap::Args for Flags<T> {
    fn augment_args(command: Command) -> Command {
        tunings::<T>().into_iter().fold(command, |command, tuning| {
            let mut arg = Arg::new(flag(&tuning))
                .long(flag(&tuning))
                .help(tuning.help)
                .help_heading(T::HEADING)
                .value_name(tuning.kind.placeholder())
                // So that `--lambda -1` is told its range rather than taken for an option.
                .allow_negative_numbers(matches!(tuning.kind, Kind::Number { .. }))
                .value_parser(parser(tuning.kind));
            match tuning.default {
                Value::Null => {}
                Value::String(text) => arg = arg.default_value(text),
                other => arg = arg.default_value(other.to_string()),
            }
            command.arg(arg)
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: Tunable> FromArgMatches for Flags<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut method = Self::default();
        method.update_from_arg_matches(matches)?;
        Ok(method)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let given = |name: &str| {
            let flag = name.replace('_', "-");
            let is_given = matches.value_source(&flag) == Some(ValueSource::CommandLine);
            is_given.then(|| matches.get_one::<Value>(&flag)).flatten()
        };
        self.0 = tuned(&self.0, given).map_err(|(name, reason)| {
            let text = format!("invalid value for '--{}': {reason}\n", name.replace('_', "-"));
            clap::Error::raw(ErrorKind::ValueValidation, text)
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::reconstruct::Parameters;
    use crate::reconstruct::primitives::Detector;
    use crate::segment::SegmentOptions;

    #[derive(Debug, Parser)]
    struct Cli {
        #[command(flatten)]
        method: Flags<Parameters>,
        #[command(flatten)]
        points: Flags<SegmentOptions>,
    }

    #[test]
    fn defaults_are_those_of_the_structures() {
        let cli = Cli::try_parse_from(["gable"]).unwrap();
        assert_eq!(cli.method.0, Parameters::default());
        assert_eq!(cli.points.0, SegmentOptions::default());
    }

    #[test]
    fn a_flag_sets_its_parameter_and_nothing_else() {
        let set = Cli::try_parse_from(["gable", "--detector", "ransac"]).unwrap().method.0;
        let mut expected = Parameters::default();
        expected.detection.detector = Detector::Ransac;
        assert_eq!(set, expected);
        let message = Cli::try_parse_from(["gable", "--detector", "ransack"]).unwrap_err().to_string();
        assert!(message.contains("region-growing") && message.contains("'ransac'"), "{message}");
        let set = Cli::try_parse_from(["gable", "--ring-width", "4.5"]).unwrap().points.0;
        assert_eq!(set, SegmentOptions { ring_width: 4.5, ..SegmentOptions::default() });
    }
}
