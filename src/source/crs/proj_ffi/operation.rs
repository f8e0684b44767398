//! Coordinate operations: which there are from one CRS to another, how good they are, and carrying them out.

use std::ptr;

use proj_sys::{
    PJ_DIRECTION_PJ_FWD, PROJ_GRID_AVAILABILITY_USE_PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID,
    PROJ_GRID_AVAILABILITY_USE_PROJ_GRID_AVAILABILITY_IGNORED,
    PROJ_SPATIAL_CRITERION_PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION, proj_concatoperation_get_step,
    proj_concatoperation_get_step_count, proj_coordoperation_get_accuracy, proj_coordoperation_get_grid_used,
    proj_coordoperation_get_grid_used_count, proj_coordoperation_has_ballpark_transformation,
    proj_create_operation_factory_context, proj_create_operations, proj_normalize_for_visualization,
    proj_operation_factory_context_destroy, proj_operation_factory_context_set_area_of_interest,
    proj_operation_factory_context_set_grid_availability_use, proj_operation_factory_context_set_spatial_criterion,
    proj_trans_generic,
};

use super::{Kind, Object, text};

/// Whether operations whose grids are not installed are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::source::crs) enum Grids {
    /// Only operations that can be carried out here.
    Installed,
    /// All operations, as if every grid were there.
    AnyKnown,
}

/// A grid that an operation uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::source::crs) struct Grid {
    pub name: String,
    pub is_available: bool,
}

impl Object {
    /// Operations from this CRS to another, best first. `area` is west, south, east, north in degrees.
    pub(in crate::source::crs) fn operations_to(
        &self,
        target: &Self,
        area: Option<[f64; 4]>,
        grids: Grids,
    ) -> Vec<Self> {
        let context = self.context.raw;
        let grid_use = match grids {
            Grids::Installed => PROJ_GRID_AVAILABILITY_USE_PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID,
            Grids::AnyKnown => PROJ_GRID_AVAILABILITY_USE_PROJ_GRID_AVAILABILITY_IGNORED,
        };
        // SAFETY: live context and objects; the factory context is destroyed before leaving, the list is taken over.
        unsafe {
            let factory = proj_create_operation_factory_context(context, ptr::null());
            if factory.is_null() {
                return Vec::new();
            }
            proj_operation_factory_context_set_grid_availability_use(context, factory, grid_use);
            proj_operation_factory_context_set_spatial_criterion(
                context,
                factory,
                PROJ_SPATIAL_CRITERION_PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION,
            );
            if let Some([west, south, east, north]) = area {
                proj_operation_factory_context_set_area_of_interest(context, factory, west, south, east, north);
            }
            let list = proj_create_operations(context, self.raw, target.raw, factory);
            proj_operation_factory_context_destroy(factory);
            self.take_list(list).into_iter().flatten().collect()
        }
    }

    /// The operation with x (or longitude) first on both sides, angles in degrees.
    pub(in crate::source::crs) fn normalized(&self) -> Option<Self> {
        // SAFETY: live context and object.
        Self::own(&self.context, unsafe { proj_normalize_for_visualization(self.context.raw, self.raw) })
    }

    /// Accuracy of an operation in metres; 0 when no change of datum is involved, `None` when nobody knows.
    pub(in crate::source::crs) fn accuracy(&self) -> Option<f64> {
        // SAFETY: live context and object; steps are owned by the new objects.
        unsafe {
            let accuracy = proj_coordoperation_get_accuracy(self.context.raw, self.raw);
            if accuracy >= 0.0 {
                return Some(accuracy);
            }
            let steps = proj_concatoperation_get_step_count(self.context.raw, self.raw);
            let only_conversions = (0..steps).all(|i| {
                Self::own(&self.context, proj_concatoperation_get_step(self.context.raw, self.raw, i))
                    .is_some_and(|step| step.kind() == Kind::Conversion)
            });
            (self.kind() == Kind::Conversion || (steps > 0 && only_conversions)).then_some(0.0)
        }
    }

    /// Whether an operation leaves a change of datum out because none is known.
    pub(in crate::source::crs) fn is_ballpark(&self) -> bool {
        // SAFETY: live context and object.
        unsafe { proj_coordoperation_has_ballpark_transformation(self.context.raw, self.raw) != 0 }
    }

    /// The grids that an operation uses.
    pub(in crate::source::crs) fn grids(&self) -> Vec<Grid> {
        // SAFETY: live context and object, indices below the count; strings belong to the object and are copied.
        unsafe {
            (0..proj_coordoperation_get_grid_used_count(self.context.raw, self.raw))
                .map(|i| {
                    let (mut name, mut available) = (ptr::null(), 0);
                    proj_coordoperation_get_grid_used(
                        self.context.raw,
                        self.raw,
                        i,
                        &raw mut name,
                        ptr::null_mut(),
                        ptr::null_mut(),
                        ptr::null_mut(),
                        ptr::null_mut(),
                        ptr::null_mut(),
                        &raw mut available,
                    );
                    Grid { name: text(name), is_available: available != 0 }
                })
                .collect()
        }
    }

    /// Carries out an operation in place; points that it cannot do become infinite.
    pub(in crate::source::crs) fn transform(&self, points: &mut [[f64; 2]]) {
        self.carry_out(points);
    }

    /// The same with heights.
    pub(in crate::source::crs) fn transform_3d(&self, points: &mut [[f64; 3]]) {
        self.carry_out(points);
    }

    fn carry_out<const D: usize>(&self, points: &mut [[f64; D]]) {
        const { assert!(D == 2 || D == 3, "x and y, or x, y and z") };
        let (count, stride) = (points.len(), size_of::<[f64; D]>());
        let Some(first) = points.first_mut() else { return };
        let x = first.as_mut_ptr();
        // SAFETY: `x`, `x + 1` and, with three coordinates, `x + 2` are the first of `count` numbers each, `stride` bytes
        // apart, all inside `points`, which is borrowed mutably; t is absent, and so is z with two. The object is live and
        // not shared between threads.
        unsafe {
            let (z, z_stride, z_count) = if D == 3 { (x.add(2), stride, count) } else { (ptr::null_mut(), 0, 0) };
            proj_trans_generic(
                self.raw,
                PJ_DIRECTION_PJ_FWD,
                x,
                stride,
                count,
                x.add(1),
                stride,
                count,
                z,
                z_stride,
                z_count,
                ptr::null_mut(),
                0,
                0,
            );
        }
    }
}
