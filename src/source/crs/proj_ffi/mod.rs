//! The one place that calls PROJ: a safe shell around the functions of `proj-sys` that the CRS module needs.
//!
//! The `proj` crate hides its context, and only the context can be told to use the database that is linked into the
//! binary; it has no identification, no sub-CRSs and no operation lists either. Everything here stays on the thread
//! that made it: a [`Context`] is shared by reference counting, so that it outlives all its objects.
#![allow(unsafe_code)]

mod operation;

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;
use std::rc::Rc;

use proj_sys::{
    PJ, PJ_COMPARISON_CRITERION_PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS, PJ_CONTEXT, PJ_LOG_LEVEL_PJ_LOG_NONE,
    PJ_OBJ_LIST, PJ_TYPE, PJ_TYPE_PJ_TYPE_BOUND_CRS, PJ_TYPE_PJ_TYPE_COMPOUND_CRS, PJ_TYPE_PJ_TYPE_CONVERSION,
    PJ_TYPE_PJ_TYPE_DERIVED_PROJECTED_CRS, PJ_TYPE_PJ_TYPE_ENGINEERING_CRS, PJ_TYPE_PJ_TYPE_GEOCENTRIC_CRS,
    PJ_TYPE_PJ_TYPE_GEOGRAPHIC_2D_CRS, PJ_TYPE_PJ_TYPE_GEOGRAPHIC_3D_CRS, PJ_TYPE_PJ_TYPE_PROJECTED_CRS,
    PJ_TYPE_PJ_TYPE_VERTICAL_CRS, PJ_WKT_TYPE_PJ_WKT1_GDAL, PJ_WKT_TYPE_PJ_WKT2_2019, PROJ_STRING_LIST, proj_as_wkt,
    proj_context_create, proj_context_destroy, proj_context_errno, proj_context_errno_string,
    proj_context_set_database_path, proj_context_set_enable_network, proj_create, proj_create_compound_crs,
    proj_create_from_wkt, proj_crs_alter_cs_linear_unit, proj_crs_demote_to_2D, proj_crs_get_coordinate_system,
    proj_crs_get_geodetic_crs, proj_crs_get_sub_crs, proj_crs_promote_to_3D, proj_cs_get_axis_count,
    proj_cs_get_axis_info, proj_destroy, proj_get_id_auth_name, proj_get_id_code, proj_get_name, proj_get_source_crs,
    proj_get_type, proj_identify, proj_int_list_destroy, proj_is_equivalent_to_with_ctx, proj_list_destroy,
    proj_list_get, proj_list_get_count, proj_log_level, proj_string_list_destroy, proj_uom_get_info_from_database,
};

pub(super) use operation::Grids;

/// The name under which PROJ (9.6) knows the database that was linked into it.
const EMBEDDED_DATABASE: &CStr = c"__embedded_proj_db__";

/// What sort of thing a PROJ object is, as far as this crate tells them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Geographic2D,
    Geographic3D,
    Geocentric,
    Projected,
    Vertical,
    Compound,
    Engineering,
    Bound,
    Conversion,
    Other,
}

/// A unit of measure of the database.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unit {
    pub name: String,
    /// Metres per unit.
    pub metres: f64,
}

/// A PROJ context with the embedded database, without network and without messages on standard error.
pub(super) struct Context {
    raw: *mut PJ_CONTEXT,
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: `raw` came from `proj_context_create`, is destroyed once, and every object holds an `Rc` to it.
        unsafe { proj_context_destroy(self.raw) };
    }
}

impl Context {
    /// A context that reads the database inside the binary whatever `PROJ_DATA` and `PROJ_LIB` say; grids are still
    /// looked for where these point.
    pub(super) fn new() -> Result<Rc<Self>, String> {
        // SAFETY: takes no argument; a null answer is handled.
        let raw = unsafe { proj_context_create() };
        if raw.is_null() {
            return Err("PROJ could not create a context".into());
        }
        let context = Rc::new(Self { raw });
        // SAFETY: `raw` is a live context and the path is a terminated string that PROJ copies. Where PROJ was not
        // built with its database inside, the call fails and PROJ goes on with its usual search.
        unsafe {
            proj_log_level(raw, PJ_LOG_LEVEL_PJ_LOG_NONE);
            proj_context_set_enable_network(raw, 0);
            proj_context_set_database_path(raw, EMBEDDED_DATABASE.as_ptr(), ptr::null(), ptr::null());
        }
        Ok(context)
    }

    /// What PROJ says of its last failure.
    fn last_error(&self) -> String {
        // SAFETY: `raw` is a live context; the string is copied before the context is used again.
        unsafe {
            let code = proj_context_errno(self.raw);
            if code == 0 { "not known to PROJ".into() } else { text(proj_context_errno_string(self.raw, code)) }
        }
    }

    /// A length unit by its EPSG code.
    pub(super) fn length_unit(&self, code: u16) -> Option<Unit> {
        let code = CString::new(code.to_string()).ok()?;
        let (mut name, mut category, mut metres) = (ptr::null(), ptr::null(), f64::NAN);
        // SAFETY: all pointers are to live values; the strings belong to the context and are copied at once.
        unsafe {
            let found = proj_uom_get_info_from_database(
                self.raw,
                c"EPSG".as_ptr(),
                code.as_ptr(),
                &raw mut name,
                &raw mut metres,
                &raw mut category,
            );
            (found != 0 && text(category) == "linear").then(|| Unit { name: text(name), metres })
        }
    }
}

/// An object of PROJ: a CRS, a coordinate system or a coordinate operation.
pub(super) struct Object {
    raw: *mut PJ,
    context: Rc<Context>,
}

impl Drop for Object {
    fn drop(&mut self) {
        // SAFETY: `raw` is a live object owned by `self`; its context is alive because `self` holds it.
        unsafe { proj_destroy(self.raw) };
    }
}

impl Object {
    fn own(context: &Rc<Context>, raw: *mut PJ) -> Option<Self> {
        (!raw.is_null()).then(|| Self { raw, context: Rc::clone(context) })
    }

    /// Anything that PROJ can make out of a text: code, URN, URI, PROJJSON, PROJ string, name.
    pub(super) fn parse(context: &Rc<Context>, definition: &str) -> Result<Self, String> {
        let c_text = CString::new(definition).map_err(|_| "it holds a zero byte".to_string())?;
        // SAFETY: a live context and a terminated string.
        let raw = unsafe { proj_create(context.raw, c_text.as_ptr()) };
        Self::own(context, raw).ok_or_else(|| context.last_error())
    }

    /// A CRS from WKT 1, WKT 2 or ESRI WKT; the error is the grammar error.
    pub(super) fn from_wkt(context: &Rc<Context>, wkt: &str) -> Result<Self, String> {
        let c_text = CString::new(wkt).map_err(|_| "it holds a zero byte".to_string())?;
        let (mut warnings, mut errors): (PROJ_STRING_LIST, PROJ_STRING_LIST) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: a live context, a terminated string, no options, two places for lists that are freed below.
        let (raw, errors) = unsafe {
            let raw =
                proj_create_from_wkt(context.raw, c_text.as_ptr(), ptr::null(), &raw mut warnings, &raw mut errors);
            proj_string_list_destroy(warnings);
            let list = strings(errors);
            proj_string_list_destroy(errors);
            (raw, list)
        };
        Self::own(context, raw).ok_or_else(|| match errors.first() {
            Some(error) => error.lines().next().unwrap_or_default().trim_end_matches(['.', ' ']).to_string(),
            None => context.last_error(),
        })
    }

    /// The compound of a horizontal and a vertical CRS.
    pub(super) fn compound(horizontal: &Self, vertical: &Self) -> Option<Self> {
        let name = CString::new(format!("{} + {}", horizontal.name(), vertical.name())).ok()?;
        let context = &horizontal.context;
        // SAFETY: a live context, a terminated string and two live objects.
        let raw = unsafe { proj_create_compound_crs(context.raw, name.as_ptr(), horizontal.raw, vertical.raw) };
        Self::own(context, raw)
    }

    pub(super) fn kind(&self) -> Kind {
        // SAFETY: a live object.
        let raw: PJ_TYPE = unsafe { proj_get_type(self.raw) };
        match raw {
            PJ_TYPE_PJ_TYPE_GEOGRAPHIC_2D_CRS => Kind::Geographic2D,
            PJ_TYPE_PJ_TYPE_GEOGRAPHIC_3D_CRS => Kind::Geographic3D,
            PJ_TYPE_PJ_TYPE_GEOCENTRIC_CRS => Kind::Geocentric,
            PJ_TYPE_PJ_TYPE_PROJECTED_CRS | PJ_TYPE_PJ_TYPE_DERIVED_PROJECTED_CRS => Kind::Projected,
            PJ_TYPE_PJ_TYPE_VERTICAL_CRS => Kind::Vertical,
            PJ_TYPE_PJ_TYPE_COMPOUND_CRS => Kind::Compound,
            PJ_TYPE_PJ_TYPE_ENGINEERING_CRS => Kind::Engineering,
            PJ_TYPE_PJ_TYPE_BOUND_CRS => Kind::Bound,
            PJ_TYPE_PJ_TYPE_CONVERSION => Kind::Conversion,
            _ => Kind::Other,
        }
    }

    pub(super) fn name(&self) -> String {
        // SAFETY: a live object; the string belongs to it and is copied.
        unsafe { text(proj_get_name(self.raw)) }
    }

    /// Authority and code, when it has them.
    pub(super) fn id(&self) -> Option<(String, String)> {
        // SAFETY: a live object; the strings belong to it and are copied.
        let (authority, code) =
            unsafe { (text(proj_get_id_auth_name(self.raw, 0)), text(proj_get_id_code(self.raw, 0))) };
        (!authority.is_empty() && !code.is_empty()).then_some((authority, code))
    }

    /// WKT 2:2019 on one line.
    pub(super) fn wkt2(&self) -> Option<String> {
        self.wkt(PJ_WKT_TYPE_PJ_WKT2_2019)
    }

    /// WKT 1 as GDAL writes it, on one line; `None` for what it cannot express.
    pub(super) fn wkt1(&self) -> Option<String> {
        self.wkt(PJ_WKT_TYPE_PJ_WKT1_GDAL)
    }

    fn wkt(&self, version: proj_sys::PJ_WKT_TYPE) -> Option<String> {
        let options = [c"MULTILINE=NO".as_ptr(), ptr::null()];
        // SAFETY: live context and object, a null-terminated list of options; the string belongs to the object.
        let wkt = unsafe { text(proj_as_wkt(self.context.raw, self.raw, version, options.as_ptr())) };
        (!wkt.is_empty()).then_some(wkt)
    }

    /// Part of a compound CRS: 0 is horizontal, 1 vertical.
    pub(super) fn sub_crs(&self, index: c_int) -> Option<Self> {
        // SAFETY: live context and object; a bad index gives null.
        Self::own(&self.context, unsafe { proj_crs_get_sub_crs(self.context.raw, self.raw, index) })
    }

    /// The CRS inside a bound CRS (one with `TOWGS84`).
    pub(super) fn source_crs(&self) -> Option<Self> {
        // SAFETY: live context and object.
        Self::own(&self.context, unsafe { proj_get_source_crs(self.context.raw, self.raw) })
    }

    /// The geographic CRS that a projected one is based on.
    pub(super) fn geodetic_crs(&self) -> Option<Self> {
        // SAFETY: live context and object.
        Self::own(&self.context, unsafe { proj_crs_get_geodetic_crs(self.context.raw, self.raw) })
    }

    /// A 3D CRS without its third axis.
    pub(super) fn demoted_to_2d(&self) -> Option<Self> {
        // SAFETY: live context and object; a null name keeps the name.
        Self::own(&self.context, unsafe { proj_crs_demote_to_2D(self.context.raw, ptr::null(), self.raw) })
    }

    /// A 2D CRS with a third axis: metres above its ellipsoid.
    pub(super) fn promoted_to_3d(&self) -> Option<Self> {
        // SAFETY: live context and object; a null name keeps the name.
        Self::own(&self.context, unsafe { proj_crs_promote_to_3D(self.context.raw, ptr::null(), self.raw) })
    }

    /// The same CRS with another unit of length on its axes; its parameters keep theirs.
    pub(super) fn with_length_unit(&self, unit: &Unit) -> Option<Self> {
        let name = CString::new(unit.name.as_str()).ok()?;
        // SAFETY: live context and object, a terminated name, and no authority for the unit.
        let raw = unsafe {
            proj_crs_alter_cs_linear_unit(
                self.context.raw,
                self.raw,
                name.as_ptr(),
                unit.metres,
                ptr::null(),
                ptr::null(),
            )
        };
        Self::own(&self.context, raw)
    }

    /// Systems of the database that this one may be, each with PROJ's confidence in per cent, best first.
    pub(super) fn identify(&self) -> Vec<(Self, i32)> {
        let mut confidence: *mut c_int = ptr::null_mut();
        // SAFETY: live context and object; no authority means all; the list of confidences has one number per entry
        // of the list of objects and is freed after it was copied.
        unsafe {
            let list = proj_identify(self.context.raw, self.raw, ptr::null(), ptr::null(), &raw mut confidence);
            let objects = self.take_list(list);
            let found = objects
                .into_iter()
                .enumerate()
                .filter_map(|(i, object)| Some((object?, if confidence.is_null() { 0 } else { *confidence.add(i) })))
                .collect();
            proj_int_list_destroy(confidence);
            found
        }
    }

    /// Metres (or radians, on the angular axes of geographic systems) per unit, along each axis.
    pub(super) fn axis_units(&self) -> Vec<f64> {
        let context = self.context.raw;
        // SAFETY: live context and object; the coordinate system is owned by the new object.
        let system = Self::own(&self.context, unsafe { proj_crs_get_coordinate_system(context, self.raw) });
        let Some(system) = system else { return Vec::new() };
        // SAFETY: a live coordinate system.
        let count = unsafe { proj_cs_get_axis_count(context, system.raw) };
        (0..count)
            .map(|axis| {
                let mut factor = f64::NAN;
                // SAFETY: a live coordinate system, an axis that it has; what is not asked for is null.
                unsafe {
                    proj_cs_get_axis_info(
                        context,
                        system.raw,
                        axis,
                        ptr::null_mut(),
                        ptr::null_mut(),
                        ptr::null_mut(),
                        &raw mut factor,
                        ptr::null_mut(),
                        ptr::null_mut(),
                        ptr::null_mut(),
                    );
                }
                factor
            })
            .collect()
    }

    /// Whether two CRSs are the same but for names and the order of geographic axes.
    pub(super) fn is_equivalent(&self, other: &Self) -> bool {
        // SAFETY: a live context and two live objects.
        unsafe {
            proj_is_equivalent_to_with_ctx(
                self.context.raw,
                self.raw,
                other.raw,
                PJ_COMPARISON_CRITERION_PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS,
            ) != 0
        }
    }

    /// The objects of a list, which is freed.
    ///
    /// # Safety
    /// `list` is null or a live list of this object's context that nobody else frees.
    unsafe fn take_list(&self, list: *mut PJ_OBJ_LIST) -> Vec<Option<Self>> {
        if list.is_null() {
            return Vec::new();
        }
        // SAFETY: by the contract above; indices are below the count.
        unsafe {
            let objects = (0..proj_list_get_count(list))
                .map(|i| Self::own(&self.context, proj_list_get(self.context.raw, list, i)))
                .collect();
            proj_list_destroy(list);
            objects
        }
    }
}

/// A copy of a C string; empty for null.
///
/// # Safety
/// `raw` is null or points to a terminated string that lives during the call.
unsafe fn text(raw: *const c_char) -> String {
    if raw.is_null() {
        return String::new();
    }
    // SAFETY: by the contract above.
    unsafe { CStr::from_ptr(raw) }.to_string_lossy().into_owned()
}

/// Copies of a null-terminated list of C strings; empty for null.
///
/// # Safety
/// `list` is null or points to pointers to terminated strings, ended by a null pointer, all alive during the call.
unsafe fn strings(list: PROJ_STRING_LIST) -> Vec<String> {
    if list.is_null() {
        return Vec::new();
    }
    // SAFETY: by the contract above; reading stops at the null pointer.
    unsafe {
        let mut copies = Vec::new();
        while !(*list.add(copies.len())).is_null() {
            copies.push(text(*list.add(copies.len())));
        }
        copies
    }
}
