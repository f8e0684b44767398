//! City models from format to format, and several into one.
//!
//! [`convert`] reads CityJSON (1.0 to 2.0) and CityJSONSeq and writes any [format](crate::sink::Format). A sequence is read
//! feature by feature; a CityJSON object is held in memory as a whole, one file at a time. Files are read twice: once for
//! their ids, of which a hash of 8 bytes each stays in memory, and once to be written. Where ids occur more than once, those
//! features are looked at in between; see [`Repeat`].
//!
//! Attributes, semantics, hierarchy and all levels of detail are kept as far as the format can hold them. Appearances,
//! geometry templates, points and lines are left out, and [`Converted::warnings`] says so.

mod extensions;
mod ids;
mod inputs;
mod losses;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::{InputError, Result};
use crate::run::output::{prepare, spare_inputs};
use crate::sink::{self, Feature, PREFIX, Written};
use crate::source::cityjson::{self, CityModel};
use crate::source::open::refuse_pipe;
use extensions::Outdated;
use ids::Survey;
use inputs::Inputs;
use losses::Losses;

pub use ids::Repeat;

/// What is to be converted.
#[derive(Debug, Clone, Default)]
pub struct Conversion {
    /// CityJSON and CityJSONSeq files; several become one model.
    pub inputs: Vec<PathBuf>,
    /// The file or folder to write; its extension chooses the format.
    pub output: PathBuf,
    /// Whether what exists is replaced.
    pub overwrite: bool,
    /// The CRS of the inputs, whatever they say.
    pub crs: Option<String>,
    /// Only geometries of these levels of detail, such as `2.2`, and terrain at whatever level it is; empty for all.
    pub lods: Vec<String>,
}

/// What came out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Converted {
    /// The output.
    pub written: Written,
    /// The features that were left out because another stands for them.
    pub repeats: Vec<Repeat>,
    /// What the user should know: what was left out, renamed or is less exact than it might be.
    pub warnings: Vec<String>,
}

/// How far a conversion is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub pass: Pass,
    /// Features of this pass so far.
    pub features: usize,
    /// Bytes that were read since the last time.
    pub bytes: u64,
}

/// What a conversion reads its inputs for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// To know all ids.
    Survey,
    /// To compare features of one id; only where there are any.
    Compare,
    /// To write.
    Write,
}

/// Converts or joins city models.
///
/// # Errors
/// An input that cannot be read; inputs whose CRSs differ, which names both; a CRS that is needed and missing; an output that
/// exists, is an input or cannot be written.
pub fn convert(conversion: &Conversion, progress: &mut dyn FnMut(Progress)) -> Result<Converted> {
    let Conversion { inputs: paths, output, overwrite, lods, .. } = conversion;
    let is_stream = sink::is_stream(output);
    if !is_stream {
        sink::Format::of(output)?;
        spare_inputs(&[output], paths.iter().map(PathBuf::as_path))?;
        prepare(output, *overwrite)?;
    }
    paths.iter().try_for_each(|path| refuse_pipe(path))?;
    let inputs = Inputs::open(paths, conversion.crs.as_deref())?;
    let mut warnings = inputs.warnings;

    let mut survey = Survey::default();
    each(paths, Pass::Survey, progress, &mut |_, model| {
        survey.see(&model);
        Ok(())
    })?;
    if survey.has_repeats() {
        let mut feature = vec![0; paths.len()];
        each(paths, Pass::Compare, progress, &mut |input, model| {
            for candidate in Feature::split(model) {
                let prefix = inputs.prefixes.get(input).map_or(PREFIX, String::as_str);
                survey.compare(&candidate, prefix, input, count(&mut feature, input));
            }
            Ok(())
        })?;
    }
    let mut ids = survey.decide();

    let mut sink = if is_stream {
        sink::stream(output, inputs.metadata)?
    } else {
        sink::create(output, inputs.metadata, *overwrite)?
    };
    let mut losses = Losses::default();
    let mut outdated = Outdated::default();
    let (mut geometries, mut seen) = (0_usize, BTreeSet::new());
    let mut features = vec![0; paths.len()];
    each(paths, Pass::Write, progress, &mut |input, mut model| {
        losses.take(&mut model);
        outdated.take(&mut model);
        let version = model.version.clone();
        if !lods.is_empty() {
            for object in &mut model.objects {
                let of_object = &mut object.geometries;
                seen.extend(of_object.iter().map(|geometry| geometry.lod.clone()));
                // Buildings stand in the terrain at whatever level of detail.
                if object.kind == "TINRelief" && !of_object.iter().any(|geometry| lods.contains(&geometry.lod)) {
                    continue;
                }
                of_object.retain(|geometry| lods.contains(&geometry.lod));
                geometries += of_object.len();
            }
        }
        for mut feature in Feature::split(model) {
            if ids.admit(&mut feature, input, count(&mut features, input)) && outdated.leave_out(&mut feature, &version)
            {
                sink.write(&feature)?;
            }
        }
        Ok(())
    })?;
    let list = |lods: &BTreeSet<String>| lods.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
    if !lods.is_empty() && geometries == 0 {
        // The sink is dropped, and nothing is written.
        let found =
            if seen.is_empty() { "no geometry".to_owned() } else { format!("geometry at LoD {} only", list(&seen)) };
        let name = paths.first().map_or(Path::new("the input"), PathBuf::as_path);
        return Err(InputError::new(name, found, format!("geometry at LoD {}", lods.join(" or "))).at("--lod").into());
    }
    let written = sink.finish()?;
    let missing: BTreeSet<String> = lods.iter().filter(|lod| !seen.contains(*lod)).cloned().collect();
    if !missing.is_empty() {
        warnings.push(format!("there is no geometry at LoD {}; there is at {}", list(&missing), list(&seen)));
    }
    let (repeats, renamed) = ids.close(paths);
    warnings.extend(losses.messages());
    warnings.extend(outdated.messages());
    warnings.extend(renamed);
    warnings.extend(written.notes.iter().cloned());
    Ok(Converted { written, repeats, warnings })
}

/// The number of the next feature of an input.
fn count(features: &mut [usize], input: usize) -> usize {
    features.get_mut(input).map_or(0, |features| {
        *features += 1;
        *features - 1
    })
}

/// Reads all inputs piece by piece.
fn each(
    paths: &[PathBuf],
    pass: Pass,
    progress: &mut dyn FnMut(Progress),
    take: &mut dyn FnMut(usize, CityModel) -> Result<()>,
) -> Result<()> {
    let mut features = 0;
    for (input, path) in paths.iter().enumerate() {
        let mut pieces = cityjson::features(path)?;
        let mut read = 0;
        while let Some(piece) = pieces.next() {
            take(input, piece?)?;
            features += 1;
            progress(Progress { pass, features, bytes: pieces.bytes_read() - read });
            read = pieces.bytes_read();
        }
    }
    Ok(())
}
