use std::path::PathBuf;

use super::*;

const FOOT: f64 = 0.3048;
const US_SURVEY_FOOT: f64 = 1200.0 / 3937.0;

fn shared(file: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(file);
    if !path.exists() {
        println!("skipped: shared data not found");
        return None;
    }
    Some(path)
}

fn of_file(file: &str) -> Option<Result<Option<Crs>, String>> {
    let reader = las::Reader::from_path(shared(file)?).unwrap();
    Some(Crs::from_header(reader.header()))
}

fn header_with(records: &[(u16, Vec<u8>)]) -> las::Header {
    let mut builder = las::Builder::from((1, 2));
    builder.vlrs = records
        .iter()
        .map(|(id, data)| las::Vlr {
            user_id: "LASF_Projection".into(),
            record_id: *id,
            description: String::new(),
            data: data.clone(),
        })
        .collect();
    builder.into_header().unwrap()
}

/// A GeoTIFF directory of short keys, as bytes.
fn keys(entries: &[(u16, u16)]) -> Vec<u8> {
    let mut shorts = vec![1, 1, 0, entries.len() as u16];
    for (key, value) in entries {
        shorts.extend([*key, 0, 1, *value]);
    }
    shorts.iter().flat_map(|s| s.to_le_bytes()).collect()
}

#[test]
fn headers_of_real_files() {
    if let Some(delft) = of_file("delft-quickstart/delft_ahn3.laz") {
        let delft = delft.unwrap().unwrap();
        assert_eq!(delft.code.as_deref(), Some("EPSG:7415"));
        assert_eq!(delft.metres_per_unit, [1.0; 3]);
        assert_eq!(delft.reference_system().unwrap(), "https://www.opengis.net/def/crs/EPSG/0/7415");
        assert!(delft.wkt.starts_with("COMPOUNDCRS["));
    }
    if let Some(ign) = of_file("ign-rural/870000_6618000.subset.postCompletion.laz") {
        assert_eq!(ign.unwrap().unwrap().code.as_deref(), Some("EPSG:2154"));
    }
    if let Some(none) = of_file("delft/ahn3_cropped_1.laz") {
        assert_eq!(none, Ok(None));
    }
    if let Some(autzen) = of_file("edge-cases/autzen-feet.laz") {
        let autzen = autzen.unwrap().unwrap();
        assert!(autzen.metres_per_unit.iter().all(|m| (m - FOOT).abs() < 1e-12), "{autzen:?}");
        assert!(!autzen.is_geographic);
    }
}

#[test]
fn codes_urns_and_uris_mean_the_same() {
    for text in [
        "EPSG:7415",
        "epsg:7415",
        " 7415 ",
        "urn:ogc:def:crs:EPSG::7415",
        "http://www.opengis.net/def/crs/EPSG/0/7415",
        "https://www.opengis.net/def/crs/EPSG/0/7415",
        "EPSG:28992+5709",
        "Amersfoort / RD New + NAP height",
    ] {
        let crs = Crs::parse(text).unwrap();
        assert_eq!(crs.code.as_deref(), Some("EPSG:7415"), "{text}");
        assert_eq!(Crs::parse(&crs.wkt).unwrap(), crs, "{text}");
    }
    assert_eq!(Crs::parse("urn:ogc:def:crs:OGC:1.3:CRS84").unwrap().code.as_deref(), Some("OGC:CRS84"));
    assert!(Crs::wgs84().unwrap().is_geographic);
}

#[test]
fn projjson_and_local_systems_are_understood() {
    let axis = |name: &str, direction: &str| {
        format!("{{\"name\":\"{name}\",\"abbreviation\":\"\",\"direction\":\"{direction}\",\"unit\":\"degree\"}}")
    };
    let json = format!(
        "{{\"type\":\"GeographicCRS\",\"name\":\"WGS 84 (CRS84)\",\"datum\":{{\"type\":\"GeodeticReferenceFrame\",\
        \"name\":\"World Geodetic System 1984\",\"ellipsoid\":{{\"name\":\"WGS 84\",\"semi_major_axis\":6378137,\
        \"inverse_flattening\":298.257223563}}}},\"coordinate_system\":{{\"subtype\":\"ellipsoidal\",\"axis\":[{},{}]}},\
        \"id\":{{\"authority\":\"OGC\",\"code\":\"CRS84\"}}}}",
        axis("Geodetic longitude", "east"),
        axis("Geodetic latitude", "north")
    );
    assert_eq!(Crs::parse(&json).unwrap().code.as_deref(), Some("OGC:CRS84"));
    let local = Crs::parse("LOCAL_CS[\"site grid\",UNIT[\"foot\",0.3048]]").unwrap();
    assert!(local.code.is_none() && local.reference_system().is_none());
    assert_eq!(local.metres_per_unit, [FOOT; 3]);
    let elsewhere = Crs::parse("EPSG:28992").unwrap();
    assert!(Transformer::new(&local, &elsewhere, None).is_err());
}

#[test]
fn a_pair_without_a_code_of_its_own_keeps_both() {
    // Lambert-93 with Belgian heights: nobody gave that a code.
    let crs = Crs::parse("EPSG:2154+5710").unwrap();
    assert_eq!(crs.code.as_deref(), Some("EPSG:2154+5710"));
    assert_eq!(crs.reference_system().unwrap(), "https://www.opengis.net/def/crs/EPSG/0/2154");
    assert_eq!(Crs::parse(crs.code.as_deref().unwrap()).unwrap(), crs);
}

#[test]
fn nonsense_is_refused_with_an_example() {
    for text in ["", "EPSG:999999", "RD new-ish", "Amersfoort / RD", "PROJCS[\"x\"", "EPSG:5709", "EPSG:4978", "{}"] {
        let error = Crs::parse(text).unwrap_err().to_string();
        assert!(error.contains("EPSG:7415"), "{text}: {error}");
    }
}

#[test]
fn units_are_read_for_plan_and_height_apart() {
    let plan = Crs::parse("EPSG:2263").unwrap().metres_per_unit;
    assert!(plan.iter().all(|m| (m - US_SURVEY_FOOT).abs() < 1e-12), "{plan:?}");
    // New York in US survey feet, NAVD88 heights in metres.
    let [x, y, z] = Crs::parse("EPSG:2263+5703").unwrap().metres_per_unit;
    assert!((x - US_SURVEY_FOOT).abs() < 1e-12 && x == y && z == 1.0);
    // Lambert-93 in metres, NAVD88 heights in US survey feet.
    let [x, _, z] = Crs::parse("EPSG:2154+6360").unwrap().metres_per_unit;
    assert!(x == 1.0 && (z - US_SURVEY_FOOT).abs() < 1e-12);
    let geographic = Crs::parse("EPSG:4326").unwrap();
    assert!(geographic.is_geographic && (geographic.metres_per_unit[0] - 111_319.49).abs() < 0.01);
}

#[test]
fn wkt1_without_authority_is_identified() {
    let esri = "PROJCS[\"RGF93_v1_Lambert-93\",GEOGCS[\"GCS_RGF93_v1\",DATUM[\"D_Reseau_Geodesique_Francais_1993_v1\",\
        SPHEROID[\"GRS_1980\",6378137.0,298.257222101]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]],\
        PROJECTION[\"Lambert_Conformal_Conic\"],PARAMETER[\"False_Easting\",700000.0],\
        PARAMETER[\"False_Northing\",6600000.0],PARAMETER[\"Central_Meridian\",3.0],\
        PARAMETER[\"Standard_Parallel_1\",49.0],PARAMETER[\"Standard_Parallel_2\",44.0],\
        PARAMETER[\"Latitude_Of_Origin\",46.5],UNIT[\"Meter\",1.0]]";
    assert_eq!(Crs::parse(esri).unwrap().code.as_deref(), Some("EPSG:2154"));
    let rd = "PROJCS[\"Amersfoort / RD New\",GEOGCS[\"Amersfoort\",DATUM[\"Amersfoort\",\
        SPHEROID[\"Bessel 1841\",6377397.155,299.1528128],\
        TOWGS84[565.417,50.3319,465.552,-0.398957,0.343988,-1.8774,4.0725]],PRIMEM[\"Greenwich\",0],\
        UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Oblique_Stereographic\"],\
        PARAMETER[\"latitude_of_origin\",52.1561605555556],PARAMETER[\"central_meridian\",5.38763888888889],\
        PARAMETER[\"scale_factor\",0.9999079],PARAMETER[\"false_easting\",155000],\
        PARAMETER[\"false_northing\",463000],UNIT[\"metre\",1]]";
    assert_eq!(Crs::parse(rd).unwrap().code.as_deref(), Some("EPSG:28992"));
    let compound = format!(
        "COMPD_CS[\"Amersfoort / RD New + NAP height\",{rd},VERT_CS[\"NAP height\",\
        VERT_DATUM[\"Normaal Amsterdams Peil\",2005],UNIT[\"metre\",1],AXIS[\"Gravity-related height\",UP]]]"
    );
    assert_eq!(Crs::parse(&compound).unwrap().code.as_deref(), Some("EPSG:7415"));
}

#[test]
fn geotiff_keys_give_compounds_and_units() {
    let read = |entries: &[(u16, u16)]| Crs::from_header(&header_with(&[(34735, keys(entries))]));
    let crs = read(&[(1024, 1), (3072, 28992), (4096, 5709)]).unwrap().unwrap();
    assert_eq!(crs.code.as_deref(), Some("EPSG:7415"));
    let crs = read(&[(1024, 1), (3072, 2263), (4096, 5703), (4099, 9001)]).unwrap().unwrap();
    assert_eq!(crs.code.as_deref(), Some("EPSG:2263+5703"));
    assert_eq!(crs.metres_per_unit[2], 1.0);
    // UTM in US survey feet: no code any more, but a unit.
    let crs = read(&[(3072, 26910), (3076, 9003)]).unwrap().unwrap();
    assert!(crs.code.is_none() && (crs.metres_per_unit[0] - US_SURVEY_FOOT).abs() < 1e-12);
    // A vertical unit without a vertical system.
    let crs = read(&[(3072, 26910), (4099, 9002)]).unwrap().unwrap();
    assert_eq!(crs.metres_per_unit, [1.0, 1.0, FOOT]);
    let crs = read(&[(1024, 2), (2048, 4326)]).unwrap().unwrap();
    assert_eq!((crs.code.as_deref(), crs.is_geographic), (Some("EPSG:4326"), true));
    assert_eq!(read(&[(1024, 1), (3072, 0)]), Ok(None));
    assert!(read(&[(1024, 1), (3072, 32767)]).is_err());
}

#[test]
fn geotiff_parameters_define_a_system() {
    // Oregon Lambert in feet by its parameters, the way autzen has it.
    let doubles: Vec<u8> =
        [41.75, -120.5, 43.0, 45.5, 1_312_335.958_005_249, 0.0].iter().flat_map(|d: &f64| d.to_le_bytes()).collect();
    let mut shorts: Vec<u16> = vec![1, 1, 0, 11];
    shorts.extend([2048, 0, 1, 32767, 2050, 0, 1, 6152, 3072, 0, 1, 32767, 3074, 0, 1, 32767, 3075, 0, 1, 8]);
    shorts.extend([3076, 0, 1, 9002]);
    for (key, place) in [(3085_u16, 0_u16), (3084, 1), (3078, 2), (3079, 3), (3086, 4)] {
        shorts.extend([key, 34736, 1, place]);
    }
    let directory = shorts.iter().flat_map(|s| s.to_le_bytes()).collect();
    let crs = Crs::from_header(&header_with(&[(34735, directory), (34736, doubles)])).unwrap().unwrap();
    assert!((crs.metres_per_unit[0] - FOOT).abs() < 1e-12);
    assert_eq!(crs.code.as_deref(), Some("EPSG:2994"));
}

#[test]
fn wkt_is_found_under_every_number_and_name_that_writers_gave_it() {
    let wkt = Crs::parse("EPSG:28992").unwrap().wkt;
    for (user, id) in [("LASF_Projection", 4224), ("liblas", 2112), ("LibLAS", 4224)] {
        let mut builder = las::Builder::from(header_with(&[(2112, Vec::new()), (id, wkt.clone().into_bytes())]));
        builder.vlrs[1].user_id = user.into();
        let crs = Crs::from_header(&builder.into_header().unwrap()).unwrap().unwrap();
        assert_eq!(crs.code.as_deref(), Some("EPSG:28992"), "{user} {id}");
    }
}

#[test]
fn a_broken_wkt_falls_back_on_keys_and_else_is_an_error() {
    let broken = (2112, b"PROJCS[\"half".to_vec());
    assert!(Crs::from_header(&header_with(std::slice::from_ref(&broken))).unwrap_err().contains("WKT"));
    let both = header_with(&[broken, (34735, keys(&[(3072, 28992)]))]);
    assert_eq!(Crs::from_header(&both).unwrap().unwrap().code.as_deref(), Some("EPSG:28992"));
    for cut in 0..12 {
        let mut directory = keys(&[(3072, 28992)]);
        directory.truncate(cut);
        assert_eq!(Crs::from_header(&header_with(&[(34735, directory)])), Ok(None));
    }
}

#[test]
fn the_same_horizontal_part_is_the_identity() {
    let [rd, compound, utm] = ["EPSG:28992", "EPSG:7415", "EPSG:32631"].map(|c| Crs::parse(c).unwrap());
    let transformer = Transformer::new(&rd, &compound, None).unwrap();
    assert!(transformer.is_identity() && transformer.warning().is_none());
    assert!(rd.is_same_horizontally(&compound) && !rd.is_same_horizontally(&utm));
    let [lat_lon, lon_lat] = ["EPSG:4326", "OGC:CRS84"].map(|c| Crs::parse(c).unwrap());
    assert!(Transformer::new(&lat_lon, &lon_lat, None).unwrap().is_identity());
}

#[test]
fn a_shift_without_its_grid_is_done_and_said() {
    let [wgs84, rd] = ["EPSG:4326", "EPSG:7415"].map(|c| Crs::parse(c).unwrap());
    let transformer = Transformer::new(&wgs84, &rd, Some([4.36, 52.0, 4.37, 52.02])).unwrap();
    // The tower of Amersfoort is the origin of RD; its ETRS89 coordinates are those of the official RDNAPTRANS test.
    let mut points = [[5.387_638_89 - 0.000_47, 52.156_160_56 - 0.000_97]];
    transformer.transform(&mut points);
    let off = (points[0][0] - 155_000.0).hypot(points[0][1] - 463_000.0);
    assert!(off < 5.0, "{points:?}");
    assert!(transformer.accuracy().is_some_and(|metres| metres >= 0.25), "{:?}", transformer.accuracy());
    let warning = transformer.warning().unwrap();
    assert!(warning.contains("EPSG:4326") && warning.contains(" m"), "{warning}");
    println!("{warning}");
}

#[test]
fn a_missing_grid_is_named() {
    let [etrs89, rd] = ["EPSG:4258", "EPSG:28992"].map(|c| Crs::parse(c).unwrap());
    let transformer = Transformer::new(&etrs89, &rd, Some([4.36, 52.0, 4.37, 52.02])).unwrap();
    if let Some(warning) = transformer.warning() {
        assert!(warning.contains("for want of the grid") && warning.contains("rdtrans2018"), "{warning}");
    } else {
        assert!(transformer.accuracy().is_some_and(|metres| metres < 0.1));
    }
}

#[test]
fn conversions_on_one_datum_are_exact_and_silent() {
    let [a, b] = ["EPSG:32631", "EPSG:32632"].map(|c| Crs::parse(c).unwrap());
    let there = Transformer::new(&a, &b, Some([5e5, 5.7e6, 5.1e5, 5.8e6])).unwrap();
    let back = Transformer::new(&b, &a, None).unwrap();
    assert!(there.warning().is_none(), "{:?}", there.warning());
    let mut points = [[505_000.0, 5_750_000.0], [f64::NAN, 0.0]];
    there.transform(&mut points);
    back.transform(&mut points[..1]);
    assert!((points[0][0] - 505_000.0).abs() < 1e-6 && (points[0][1] - 5_750_000.0).abs() < 1e-6);
    assert!(!points[1][0].is_finite());
}

#[test]
fn a_ballpark_shift_says_that_it_is_one() {
    let local = "GEOGCRS[\"moon base\",DATUM[\"moon base\",ELLIPSOID[\"ball\",6370000,0]],CS[ellipsoidal,2],\
        AXIS[\"lon\",east],AXIS[\"lat\",north],ANGLEUNIT[\"degree\",0.0174532925199433]]";
    let [from, to] = [local, "EPSG:28992"].map(|c| Crs::parse(c).unwrap());
    let transformer = Transformer::new(&from, &to, None).unwrap();
    assert_eq!(transformer.accuracy(), None);
    assert!(transformer.warning().unwrap().contains("hundreds of metres"), "{:?}", transformer.warning());
}

#[test]
fn a_vertical_datum_that_nobody_knows_leaves_the_horizontal_code() {
    let wkt = |crs: &str| Crs::parse(crs).unwrap().wkt1().unwrap();
    let local = r#"VERT_CS["my geoid",VERT_DATUM["./local.bin",2005],UNIT["metre",1],AXIS["Up",UP]]"#;
    let crs = Crs::parse(&format!(r#"COMPD_CS["RD + local",{},{local}]"#, wkt("EPSG:28992"))).unwrap();
    assert_eq!(crs.code.as_deref(), Some("EPSG:28992"));
    assert_eq!(crs.unknown_heights().as_deref(), Some("my geoid"));
    assert_eq!(crs.reference_system().as_deref(), Some("https://www.opengis.net/def/crs/EPSG/0/28992"));
    for known in ["EPSG:28992", "EPSG:7415", "EPSG:2154+5720"] {
        assert_eq!(Crs::parse(known).unwrap().unknown_heights(), None, "{known}");
    }
}
