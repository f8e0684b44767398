//! Rasters that are written here, and read.

use std::fs::File;

use tempfile::tempdir;
use tiff::encoder::colortype::{ColorType, Gray16, Gray32Float, Gray64Float, GrayI16};
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, TiffEncoder, TiffValue};
use tiff::tags::Predictor;

use super::*;

/// Keys that say EPSG:28992, and whether places are centres of pixels.
fn keys(is_point: bool) -> [u16; 16] {
    [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, if is_point { 2 } else { 1 }, 3072, 0, 1, 28992]
}

struct Written {
    folder: tempfile::TempDir,
    path: PathBuf,
}

/// Writes a raster of 40 × 30 pixels of 2 m whose corner is at (1000, 2000).
fn write<C: ColorType>(
    compression: Compression,
    predictor: Predictor,
    nodata: Option<&str>,
    is_point: bool,
    value: impl Fn(u32, u32) -> C::Inner,
) -> Written
where
    [C::Inner]: TiffValue,
{
    let folder = tempdir().unwrap();
    let path = folder.path().join("dtm.tif");
    let file = File::create(&path).unwrap();
    let mut encoder = TiffEncoder::new(file).unwrap().with_compression(compression).with_predictor(predictor);
    let mut image = encoder.new_image::<C>(40, 30).unwrap();
    image.rows_per_strip(7).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[2.0, 2.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 1000.0, 2000.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(is_point)[..]).unwrap();
    if let Some(nodata) = nodata {
        tags.write_tag(Tag::GdalNodata, nodata).unwrap();
    }
    let data: Vec<C::Inner> =
        (0..30).flat_map(|row| (0..40).map(move |column| (column, row))).map(|(c, r)| value(c, r)).collect();
    image.write_data(&data).unwrap();
    Written { folder, path }
}

/// 10 m, rising by 0.1 m a column and falling by 0.05 m a row.
fn slope(column: u32, row: u32) -> f64 {
    10.0 + 0.1 * f64::from(column) - 0.05 * f64::from(row)
}

#[test]
fn heights_lie_between_the_centres_of_pixels() {
    let deflate = Compression::Deflate(DeflateLevel::Fast);
    let files = [
        write::<Gray32Float>(Compression::Uncompressed, Predictor::None, None, false, |c, r| slope(c, r) as f32),
        write::<Gray32Float>(Compression::Lzw, Predictor::None, None, false, |c, r| slope(c, r) as f32),
        write::<Gray64Float>(deflate, Predictor::None, None, false, slope),
    ];
    for file in &files {
        let mut raster = HeightRaster::open(&file.path).unwrap();
        assert_eq!(raster.crs().unwrap().code.as_deref(), Some("EPSG:28992"));
        assert_eq!(raster.extent(), [1000.0, 1940.0, 1080.0, 2000.0]);
        // The centre of a pixel, a place between four of them, on the seam of two strips, and the outermost corner.
        for (place, expected) in [
            ([1001.0, 1999.0], 10.0),
            ([1010.5, 1989.0], slope(0, 5) + 0.1 * 4.75),
            ([1030.0, 1986.0], 10.0 + 0.1 * 14.5 - 0.05 * 6.5),
            ([1000.0, 2000.0], 10.0),
            ([1080.0, 1940.0], slope(39, 29)),
        ] {
            let found = raster.height(place).unwrap().unwrap();
            assert!((found - expected).abs() < 1e-5, "{place:?} {found} {expected}");
        }
        assert_eq!(raster.height([999.0, 1990.0]).unwrap(), None);
        assert_eq!(raster.height([f64::INFINITY, 1990.0]).unwrap(), None);
    }
}

#[test]
fn whole_numbers_and_places_at_centres_are_understood() {
    let file =
        write::<GrayI16>(Compression::Uncompressed, Predictor::Horizontal, None, true, |c, r| c as i16 - r as i16);
    let mut raster = HeightRaster::open(&file.path).unwrap();
    assert_eq!(raster.height([1000.0, 2000.0]).unwrap(), Some(0.0));
    assert_eq!(raster.height([1005.0, 2000.0]).unwrap(), Some(2.5));
    let file =
        write::<Gray16>(Compression::Lzw, Predictor::None, Some("65535"), false, |c, _| if c == 3 { 65535 } else { 7 });
    let mut raster = HeightRaster::open(&file.path).unwrap();
    // The nearest pixel has none; the one beside it has, and what it lacks is made up from the others.
    assert_eq!(raster.height([1007.0, 1999.0]).unwrap(), None);
    assert_eq!(raster.height([1005.5, 1999.0]).unwrap(), Some(7.0));
}

#[test]
fn what_has_no_height_is_told_apart_whatever_its_decimals() {
    let missing = -3.402_823_5e38_f32;
    let file =
        write::<Gray32Float>(Compression::Uncompressed, Predictor::None, Some("-3.4028235e+38"), false, |c, r| {
            if c < 20 {
                missing
            } else if r == 0 {
                f32::NAN
            } else {
                2.5
            }
        });
    let mut raster = HeightRaster::open(&file.path).unwrap();
    for (place, expected) in [([1010.0, 1980.0], None), ([1051.0, 1999.5], None), ([1051.0, 1980.0], Some(2.5))] {
        assert_eq!(raster.height(place).unwrap(), expected);
    }
}

#[test]
fn what_no_place_of_the_earth_is_as_high_as_is_no_height() {
    let file = write::<Gray32Float>(Compression::Uncompressed, Predictor::None, None, false, |c, _| match c {
        0..20 => 1e20,
        20..30 => -100_001.0,
        _ => 8_848.0,
    });
    let mut raster = HeightRaster::open(&file.path).unwrap();
    for (x, expected) in [(1010.0, None), (1050.0, None), (1071.0, Some(8_848.0))] {
        assert_eq!(raster.height([x, 1980.0]).unwrap(), expected);
    }
}

#[test]
fn what_is_no_terrain_model_is_refused_with_its_name() {
    let folder = tempdir().unwrap();
    let refused = |path: &Path, parts: &[&str]| {
        let message = HeightRaster::open(path).err().unwrap().to_string();
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    };
    refused(&folder.path().join("none.tif"), &["none.tif", "cannot open"]);
    let text = folder.path().join("text.tif");
    std::fs::write(&text, "no raster").unwrap();
    refused(&text, &["text.tif", "expected a terrain model in GeoTIFF"]);
    let plain = folder.path().join("plain.tif");
    let mut encoder = TiffEncoder::new(File::create(&plain).unwrap()).unwrap();
    encoder.write_image::<Gray16>(2, 2, &[1, 2, 3, 4]).unwrap();
    refused(&plain, &["plain.tif", "no place", "ModelTiepoint"]);
    // A file that is cut off fails where it is read, and not with a panic.
    let file = write::<Gray32Float>(Compression::Uncompressed, Predictor::None, None, false, |c, r| slope(c, r) as f32);
    let bytes = std::fs::read(&file.path).unwrap();
    let cut = file.folder.path().join("cut.tif");
    for length in (0..bytes.len()).step_by(97) {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let Ok(mut raster) = HeightRaster::open(&cut) else { continue };
        if let Err(error) = raster.height([1075.0, 1945.0]) {
            assert!(error.to_string().contains("cut.tif"), "{error}");
        }
    }
}

#[test]
fn scale_and_offset_of_gdal_are_read() {
    let metadata = "<GDALMetadata>\n<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.01</Item>\n\
        <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-50</Item></GDALMetadata>";
    assert_eq!(of_role(metadata, "scale"), Some(0.01));
    assert_eq!(of_role(metadata, "offset"), Some(-50.0));
    assert_eq!(of_role("", "scale"), None);
}
