//! The embedded networks, and files that are none.

use std::collections::HashMap;

use safetensors::tensor::{Dtype, TensorView};

use super::*;
use crate::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS};
use crate::reconstruct::occupancy::network::{Network, Queries};

fn embedded(bytes: &[u8]) -> OnnxNetwork {
    let file = NetworkFile::parse(bytes, Path::new(EMBEDDED)).unwrap();
    OnnxNetwork::new(&file, Runtime::start(None).unwrap()).unwrap()
}

/// Queries with made-up numbers.
fn queries(count: usize, interface: Interface) -> Queries {
    let numbers = |width: usize| (0..count * width).map(|i| ((i * 37 % 101) as f32) / 101.0 - 0.5).collect();
    match interface {
        Interface::Field { code, neighbours, .. } => Queries {
            count,
            code: numbers(code),
            place: numbers(PLACE_CHANNELS.len()),
            patch: numbers(neighbours * PATCH_CHANNELS.len()),
            subsample: Vec::new(),
        },
        Interface::Points2Surf { neighbours, subsample } => {
            Queries { count, patch: numbers(3 * neighbours), subsample: numbers(3 * subsample), ..Queries::default() }
        }
    }
}

#[test]
fn an_answer_does_not_depend_on_the_queries_beside_it() {
    for bytes in [FIELD, POINTS2SURF] {
        let network = embedded(bytes);
        let many = queries(300, network.interface());
        let all = network.decode(&many).unwrap();
        assert_eq!(all.len(), 300);
        assert_eq!(all, network.decode(&many).unwrap());
        let alone = network.decode(&Queries { count: 1, ..many.clone() }).unwrap();
        assert!((alone[0].inside - all[0].inside).abs() < 1e-4 && (alone[0].distance - all[0].distance).abs() < 1e-4);
        assert!(all.iter().all(|answer| answer.distance >= 0.0 && answer.distance <= 1.0));
        assert!(network.decode(&Queries { count: 301, ..many }).is_err(), "too few numbers are refused");
    }
}

#[test]
fn threads_get_the_same_answers() {
    let network = embedded(FIELD);
    let many = queries(64, network.interface());
    let alone = network.decode(&many).unwrap();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(|| network.decode(&many).unwrap())).collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), alone);
        }
    });
}

/// The embedded file with some entries of its metadata changed, and the decoder replaced.
fn changed(entries: &[(&str, Option<&str>)], decoder: Option<&[u8]>) -> Vec<u8> {
    let (_, header) = safetensors::SafeTensors::read_metadata(FIELD).unwrap();
    let mut metadata: HashMap<String, String> = header.metadata().clone().unwrap();
    for (key, value) in entries {
        match value {
            Some(value) => metadata.insert((*key).into(), (*value).into()),
            None => metadata.remove(*key),
        };
    }
    let file = NetworkFile::parse(FIELD, Path::new(EMBEDDED)).unwrap();
    let encoder = file.encoder.unwrap();
    let decoder = decoder.unwrap_or(&file.decoder);
    let view = |bytes| TensorView::new(Dtype::U8, vec![<[u8]>::len(bytes)], bytes).unwrap();
    safetensors::serialize([("encoder.onnx", view(&encoder)), ("decoder.onnx", view(decoder))], Some(metadata)).unwrap()
}

#[test]
fn a_file_that_does_not_fit_is_refused_with_what_differs() {
    let path = Path::new("mine.safetensors");
    for (bytes, message) in [
        (b"PK\x03\x04 something else".to_vec(), "mine.safetensors: found no readable safetensors file"),
        (changed(&[("version", Some("2"))], None), "mine.safetensors, entry `version`: found `2`, expected `1`"),
        (
            changed(&[("interface", Some("sdf"))], None),
            "entry `interface`: found `sdf`, expected `field` or `points2surf`",
        ),
        (
            changed(&[("place_channels", Some("x,y,z"))], None),
            "entry `place_channels`: found `x,y,z`, expected `x,y,z,height",
        ),
        (changed(&[("grid", Some("-3"))], None), "entry `grid`: found `-3`, expected a number from 1 to"),
        (changed(&[("batch", None)], None), "entry `batch`: found nothing"),
    ] {
        let fault = NetworkFile::parse(&bytes, path).unwrap_err().to_string();
        assert!(fault.contains(message), "{fault}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.safetensors");
    let load = |bytes: &[u8], field: Field| {
        std::fs::write(&path, bytes).unwrap();
        FieldOptions { field, model: Some(path.clone()), ..FieldOptions::default() }.load().unwrap_err().to_string()
    };
    for (bytes, field, message) in [
        (changed(&[("neighbours", Some("5"))], None), Field::Neural, "found graphs that cannot be run"),
        (changed(&[], Some(b"no graph")), Field::Neural, "found graphs that cannot be run"),
        (
            FIELD.to_vec(),
            Field::Points2Surf,
            "a network of another interface (field), expected one for --field points2surf",
        ),
        (FIELD.to_vec(), Field::HeightField, "--model: found a value, expected none with --field height-field"),
    ] {
        let fault = load(&bytes, field);
        assert!(fault.contains(message), "{fault}");
    }
}

#[test]
fn bytes_that_are_flipped_never_crash() {
    let header = 8 + u64::from_le_bytes(FIELD[..8].try_into().unwrap()) as usize;
    for at in (0..header + 64).step_by(7) {
        let mut bytes = FIELD.to_vec();
        bytes[at] ^= 0x55;
        let _ = NetworkFile::parse(&bytes, Path::new("flipped"));
    }
    for length in [0, 4, 8, header / 2, header, FIELD.len() - 1] {
        assert!(NetworkFile::parse(&FIELD[..length], Path::new("cut")).is_err(), "{length}");
    }
}
