//! Attributes of one name: none is lost without a word.

use std::fs;

use serde_json::json;
use tempfile::TempDir;

use super::super::{FootprintOptions, read};
use super::{polygon, square};

#[test]
fn names_that_a_dbase_table_has_shortened_to_one_stay_two_attributes() {
    use ::shapefile::dbase::{FieldName, FieldValue, Record, TableWriterBuilder};
    use ::shapefile::{Point, Polygon, PolygonRing, Writer};
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.shp");
    let field = |name: &str| FieldName::try_from(name).unwrap();
    let table = TableWriterBuilder::new().add_character_field(field("building_i"), 8);
    let table = table.add_character_field(field("building_n"), 8);
    let mut writer = Writer::from_path(&path, table).unwrap();
    let ring = [(0.0, 0.0), (0.0, 5.0), (5.0, 5.0), (5.0, 0.0)].map(|(x, y)| Point::new(x, y));
    let mut record = Record::default();
    record.insert("building_i".into(), FieldValue::Character(Some("b1".into())));
    record.insert("building_n".into(), FieldValue::Character(Some("Town hall".into())));
    writer.write_shape_and_record(&Polygon::new(PolygonRing::Outer(ring.to_vec())), &record).unwrap();
    drop(writer);
    // Programs that shorten `building_id` and `building_is` do not see to it that they differ.
    let table = path.with_extension("dbf");
    let mut bytes = fs::read(&table).unwrap();
    let second = bytes.windows(10).position(|name| name == b"building_n").unwrap();
    bytes[second..second + 10].copy_from_slice(b"building_i");
    fs::write(&table, bytes).unwrap();
    let layer = read(&path, &FootprintOptions::default()).unwrap();
    let attributes = &layer.footprints[0].attributes.to_map();
    assert_eq!((&attributes["building_i"], &attributes["building_i_2"]), (&json!("b1"), &json!("Town hal")));
    let told = "another attribute is called `building_i` as well: it is read as `building_i_2`";
    assert!(layer.warnings.iter().any(|warning| warning == told), "{:?}", layer.warnings);
}

#[test]
fn flatgeobuf_keeps_columns_of_one_name_apart() {
    use ::flatgeobuf::{ColumnType, FgbWriter, FgbWriterOptions, GeometryType};
    use geozero::{ColumnValue, PropertyProcessor};
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.fgb");
    let mut writer =
        FgbWriter::create_with_options("panden", GeometryType::Polygon, FgbWriterOptions::default()).unwrap();
    writer.add_column("height", ColumnType::Int, |_, _| {});
    writer.add_column("height", ColumnType::Int, |_, _| {});
    let shape = geo::Geometry::Polygon(geo::Rect::new((0.0, 0.0), (10.0, 20.0)).to_polygon());
    writer
        .add_feature_geom(shape, |feature| {
            feature.property(0, "height", &ColumnValue::Int(7)).unwrap();
            feature.property(1, "height", &ColumnValue::Int(9)).unwrap();
        })
        .unwrap();
    let mut bytes = Vec::new();
    writer.write(&mut bytes).unwrap();
    fs::write(&path, &bytes).unwrap();
    let layer = read(&path, &FootprintOptions::default()).unwrap();
    assert_eq!(serde_json::Value::Object(layer.footprints[0].attributes.to_map()), json!({"height": 7, "height_2": 9}));
    assert!(layer.warnings[0].contains("`height_2`"), "{:?}", layer.warnings);
}

#[test]
fn geojson_tells_names_that_are_repeated_and_ids_that_differ() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.geojson");
    let mut features: Vec<_> = (0..3)
        .map(|i| polygon(&json!({"id": i, "height": 3}), &json!([square(f64::from(i) * 20.0, 0.0, 10.0)])))
        .collect();
    features[0]["id"] = json!("way/1");
    features[1]["id"] = json!(1);
    let text = json!({"type": "FeatureCollection", "features": features}).to_string();
    fs::write(&path, text.replacen("\"height\":3", "\"height\":3,\"height\":4", 2)).unwrap();
    let layer = read(&path, &FootprintOptions::default()).unwrap();
    assert_eq!(layer.footprints[0].attributes.to_map()["height"], json!(4));
    let told = layer.warnings.join("\n");
    assert!(told.contains("`height` stands more than once in one object (2 times)"), "{told}");
    assert!(told.contains("1 features have an `id` of their own and another"), "{told}");
}

#[test]
fn a_name_that_differs_from_several_in_case_is_refused() {
    let folder = TempDir::new().unwrap();
    let features = [polygon(&json!({"Id": "a", "ID": "b", "h": 1}), &json!([square(0.0, 0.0, 10.0)]))];
    let path = super::geojson(&folder, &features);
    let options = |id: Option<&str>, filter: Option<&str>| FootprintOptions {
        id_attribute: id.map(str::to_owned),
        filter: filter.map(str::to_owned),
        ..FootprintOptions::default()
    };
    assert_eq!(super::ids(&read(&path, &options(Some("ID"), Some("Id = 'a' AND H = 1"))).unwrap()), ["b"]);
    for options in [options(Some("id"), None), options(None, Some("id = 'a'"))] {
        let message = read(&path, &options).unwrap_err().to_string();
        assert!(message.contains("several that differ from it in case") && message.contains("Id, ID"), "{message}");
    }
}
