// What makers of city models call the things that gable knows under names of its own: the 3DBAG, in its releases since 2023
// (`b3_…`) and before (the same names without it), and roofer, the program that makes it (`rf_…`).

const LODS = ['12', '13', '22'];
const named = (lod) => `LoD ${lod[0]}.${lod[1]}`;
const perLod = (make) => LODS.map(make);

/**
 * The concepts: what the page calls them, their unit (`CRS`: the vertical unit of the CRS), their names, gable's first, and what
 * they mean. `range` is the scale of their colours, the same in every model.
 */
const CONCEPTS = [
  concept('roofType', 'roof type', '', ['gable_roof_type', 'b3_dak_type', 'rf_roof_type']),
  concept('ground', 'ground height', 'CRS', ['gable_height_ground', 'b3_h_maaiveld', 'rf_h_ground']),
  ...[
    ['min', 'lowest'],
    ['50p', 'median'],
    ['70p', '70th percentile of the'],
    ['max', 'highest'],
  ].map(([key, which]) =>
    concept(
      `roof_${key}`,
      `roof height, ${key}`,
      'CRS',
      [`gable_height_roof_${key}`, `b3_h_dak_${key}`, `b3_h_${key}`, `rf_h_roof_${key}`, `rf_roof_elevation_${key}`],
      `${which} height of the roof`,
    ),
  ),
  concept(
    'ridge',
    'ridge height',
    'CRS',
    ['gable_height_ridge', 'b3_h_nok', 'rf_h_roof_ridge'],
    'height of the highest ridge',
  ),
  concept(
    'planes',
    'roof planes',
    '',
    ['gable_roof_planes', 'b3_n_vlakken', 'rf_roof_planes', 'rf_roof_n_planes'],
    'number of roof planes',
  ),
  ...perLod((lod) =>
    concept(
      `rmse_lod${lod}`,
      `RMSE, ${named(lod)}`,
      'm',
      names(`rmse_lod${lod}`),
      `root mean square distance of the points to the model at ${named(lod)}`,
      [0, 0.5],
    ),
  ),
  ...perLod((lod) =>
    concept(
      `volume_lod${lod}`,
      `volume, ${named(lod)}`,
      'm³',
      names(`volume_lod${lod}`),
      `volume at ${named(lod)}`,
      [0, 2000],
    ),
  ),
  ...perLod((lod) =>
    concept(
      `validity_lod${lod}`,
      `validity, ${named(lod)}`,
      '',
      [`gable_validity_lod${lod}`, `b3_val3dity_lod${lod}`, `b3_val3dity_codes_lod${lod}`, `rf_val3dity_lod${lod}`],
      `val3dity codes of the faults at ${named(lod)}; empty when valid`,
    ),
  ),
  concept(
    'quality',
    'quality indicator',
    '',
    ['b3_kwaliteitsindicator'],
    'whether the maker holds the model for correct: no overlap, no invalid solid, good points that are recent enough',
  ),
  concept(
    'steps',
    'extrusion',
    '',
    ['gable_ladder_step', 'b3_extrusie', 'rf_extrusion_mode'],
    'how the model was made: with its roof, as a block, or not at all',
  ),
  concept(
    'success',
    'success',
    '',
    ['gable_success', 'b3_succes', 'rf_success'],
    'whether the building was reconstructed',
  ),
  concept(
    'incomplete',
    'reconstruction incomplete',
    '',
    ['b3_reconstructie_onvolledig', 'b3_reconstruction_skipped'],
    'whether it was not reconstructed as a whole',
  ),
  concept('time', 'time', 'ms', ['b3_t_run', 'rf_t_run', 'rf_reconstruction_time'], 'time to reconstruct it'),
  concept('storeys', 'storeys', '', ['b3_bouwlagen'], 'estimated number of storeys'),
  concept('overlap', 'overlap', 'm²', ['b3_bag_bag_overlap'], 'area of the footprint under other footprints'),
  concept('area_ground', 'ground area', 'm²', ['b3_opp_grond'], 'area of the ground floor'),
  concept('area_flat', 'flat roof area', 'm²', ['b3_opp_dak_plat'], 'area of the flat parts of the roof'),
  concept('area_slanted', 'slanted roof area', 'm²', ['b3_opp_dak_schuin'], 'area of the slanted parts of the roof'),
  concept('area_party', 'party wall area', 'm²', ['b3_opp_scheidingsmuur'], 'area of the walls shared with neighbours'),
  concept('area_outer', 'outer wall area', 'm²', ['b3_opp_buitenmuur'], 'area of the walls in the open'),
  concept(
    'source',
    'point cloud',
    '',
    ['gable_point_cloud_source', 'b3_pw_bron', 'rf_pc_source'],
    'the point cloud that it was made from',
  ),
  concept(
    'date',
    'point cloud date',
    '',
    ['gable_point_cloud_date', 'b3_pw_datum', 'rf_pc_year'],
    'when the point cloud was recorded',
  ),
  concept(
    'selection',
    'why this point cloud',
    '',
    ['b3_pw_selectie_reden', 'rf_pc_select'],
    'why the point cloud was chosen among several',
  ),
  concept(
    'insufficient',
    'points insufficient',
    '',
    ['b3_pw_onvoldoende', 'rf_pointcloud_unusable'],
    'whether the point cloud did not suffice',
  ),
  concept(
    'density',
    'point density',
    '1/m²',
    ['gable_point_density', 'b3_puntdichtheid', 'rf_pt_density'],
    'points per area of the footprint',
    [0, 30],
  ),
  concept(
    'noData',
    'no data share',
    '',
    ['gable_no_data_share', 'b3_nodata_fractie', 'rf_nodata_frac'],
    'share of the footprint without points',
    [0, 1],
  ),
  concept(
    'noDataRadius',
    'no data radius',
    'm',
    ['b3_nodata_radius', 'rf_nodata_r'],
    'radius of the largest circle in the footprint without points',
  ),
  concept('changed', 'changed', '', ['b3_mutatie', 'rf_is_mutated'], 'whether it changed between two point clouds'),
  concept('glass', 'glass roof', '', ['b3_is_glas_dak', 'rf_is_glass_roof'], 'whether the roof is taken for glass'),
  concept(
    'greenhouse',
    'greenhouse or warehouse',
    '',
    ['b3_kas_warenhuis'],
    'whether it is a greenhouse or a warehouse, or very large',
  ),
  concept('dataArea', 'area with data', 'm²', ['b3_data_area'], 'area of the footprint with points'),
  concept(
    'coverage',
    'coverage',
    '',
    ['gable_coverage', 'b3_data_coverage'],
    'share of the footprint that is covered',
    [0, 1],
  ),
  concept('confidence', 'confidence', '', ['gable_confidence'], 'how far the model can be trusted', [0, 1]),
  concept(
    'slope',
    'slope',
    '°',
    ['slope', 'b3_hellingshoek', 'rf_slope'],
    'angle between the roof and the horizontal',
    [0, 90],
  ),
  concept(
    'azimuth',
    'azimuth',
    '°',
    ['azimuth', 'b3_azimut', 'rf_azimuth'],
    'direction that the roof falls to, clockwise from north',
    [0, 360],
  ),
  concept('surface_min', 'height min', 'CRS', ['height_min'], 'height of the lowest corner'),
  concept('surface_max', 'height max', 'CRS', ['height_max'], 'height of the highest corner'),
];

function concept(key, title, unit, all, meaning = title, range = null) {
  return { key, title, unit, names: all, meaning, range };
}

/** The names that differ by the maker alone. */
function names(name) {
  return ['gable', 'b3', 'rf'].map((maker) => `${maker}_${name}`);
}

/** The makers, by how the names of their attributes begin. */
const MAKERS = [
  [/^gable_/, 'gable'],
  [/^b3_/, 'the 3DBAG'],
  [/^rf_/, 'roofer'],
];

/** Names of the 3DBAG before 2023, by which a model is known to be one. */
const OLD = ['h_maaiveld', 'dak_type'];

/** What the attributes of a model mean. */
export class Vocabulary {
  constructor(head, objects) {
    // Of gable's own attributes the model brings names, units and meanings along.
    this.ours = new Map(head.attributes.map((attribute) => [attribute.name, attribute]));
    this.isOld3dbag = objects.some(({ attributes }) => OLD.every((name) => name in attributes));
    this.byName = new Map(CONCEPTS.flatMap((own) => own.names.map((name) => [name, own])));
    const unit = head.metres_per_unit[2];
    this.heightUnit = unit === 1 ? 'm' : Math.abs(unit - 0.3048) < 1e-5 ? 'ft' : 'units of the CRS';
  }

  /** The names of a concept, gable's first. */
  namesOf(key) {
    const all = CONCEPTS.find((own) => own.key === key)?.names ?? [];
    const old = this.isOld3dbag ? all.filter((name) => name.startsWith('b3_')).map((name) => name.slice(3)) : [];
    return [...all, ...old];
  }

  /** The concept of a name: the name itself, or the name before the point cloud that it ends with. */
  conceptOf(name) {
    const whole = this.isOld(name) ? `b3_${name}` : name;
    const general = whole.replace(/(_ahn\d+|_AHN\d+|_\d{4})+$/, '');
    return this.byName.get(whole) ?? this.byName.get(general) ?? null;
  }

  isOld(name) {
    const isOwn = this.byName.has(`b3_${name}`) || this.byName.has(`b3_${name}`.replace(/_ahn\d+$/, ''));
    return this.isOld3dbag && !this.byName.has(name) && isOwn;
  }

  /** Who gave an attribute its name: `gable`, `the 3DBAG`, `roofer`, or null for the source. */
  makerOf(name) {
    const maker = MAKERS.find(([begins]) => begins.test(name))?.[1] ?? null;
    return maker ?? (this.isOld(name) ? 'the 3DBAG' : null);
  }

  /** What is known of a name, as { title, unit, meaning, range }; null of a name that only its source knows. */
  known(name) {
    const own = this.conceptOf(name);
    const ours = this.ours.get(name);
    if (!own && !ours) {
      return null;
    }
    const unit = ours?.unit ?? own.unit;
    return {
      title: ours ? wordsOf(name) : titleOf(name, own),
      unit: unit === 'CRS' ? this.heightUnit : unit,
      meaning: ours?.meaning ?? own.meaning,
      range: own?.range ?? null,
    };
  }
}

const wordsOf = (name) => name.replace(/^gable_/, '').replace(/[_-]+/g, ' ');

/** A title; with the point cloud that the name ends with. */
function titleOf(name, own) {
  const cloud = name.match(/((?:_(?:ahn\d+|AHN\d+|\d{4}))+)$/)?.[1];
  return cloud ? `${own.title}, ${cloud.slice(1).replaceAll('_', ' to ').toUpperCase()}` : own.title;
}
