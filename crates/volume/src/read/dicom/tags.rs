//! The data elements that are looked at: numbers and keywords of PS3.6.

use crate::error::{Error, ErrorKind};
use std::fmt;

/// Group and element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Tag(pub(super) u16, pub(super) u16);

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:04X},{:04X})", self.0, self.1)
    }
}

/// What an element is called in messages: `PixelSpacing (0028,0030)`.
pub(super) fn field_name(tag: Tag) -> String {
    match KEYWORDS.iter().find(|(known, _)| *known == tag) {
        Some((_, keyword)) => format!("{keyword} {tag}"),
        None => tag.to_string(),
    }
}

/// The error of an element that is not there.
pub(super) fn missing(tag: Tag, allowed: &str) -> Error {
    ErrorKind::Missing {
        field: field_name(tag),
        allowed: allowed.to_owned(),
    }
    .into()
}

macro_rules! tags {
    ($($name:ident = $group:literal, $element:literal, $keyword:literal;)*) => {
        $(pub(super) const $name: Tag = Tag($group, $element);)*
        const KEYWORDS: &[(Tag, &str)] = &[$(($name, $keyword)),*];
    };
}

tags! {
    TRANSFER_SYNTAX_UID = 0x0002, 0x0010, "TransferSyntaxUID";
    DIRECTORY_RECORD_SEQUENCE = 0x0004, 0x1220, "DirectoryRecordSequence";
    REFERENCED_FILE_ID = 0x0004, 0x1500, "ReferencedFileID";
    SPECIFIC_CHARACTER_SET = 0x0008, 0x0005, "SpecificCharacterSet";
    IMAGE_TYPE = 0x0008, 0x0008, "ImageType";
    SOP_CLASS_UID = 0x0008, 0x0016, "SOPClassUID";
    SOP_INSTANCE_UID = 0x0008, 0x0018, "SOPInstanceUID";
    STUDY_DATE = 0x0008, 0x0020, "StudyDate";
    ACQUISITION_DATE_TIME = 0x0008, 0x002A, "AcquisitionDateTime";
    ACQUISITION_TIME = 0x0008, 0x0032, "AcquisitionTime";
    CONTENT_TIME = 0x0008, 0x0033, "ContentTime";
    MODALITY = 0x0008, 0x0060, "Modality";
    MANUFACTURER = 0x0008, 0x0070, "Manufacturer";
    CODE_MEANING = 0x0008, 0x0104, "CodeMeaning";
    STUDY_DESCRIPTION = 0x0008, 0x1030, "StudyDescription";
    SERIES_DESCRIPTION = 0x0008, 0x103E, "SeriesDescription";
    MANUFACTURER_MODEL_NAME = 0x0008, 0x1090, "ManufacturerModelName";
    FRAME_TYPE = 0x0008, 0x9007, "FrameType";
    COMPLEX_IMAGE_COMPONENT = 0x0008, 0x9208, "ComplexImageComponent";
    BODY_PART_EXAMINED = 0x0018, 0x0015, "BodyPartExamined";
    SLICE_THICKNESS = 0x0018, 0x0050, "SliceThickness";
    KVP = 0x0018, 0x0060, "KVP";
    ECHO_TIME = 0x0018, 0x0081, "EchoTime";
    INVERSION_TIME = 0x0018, 0x0082, "InversionTime";
    SPACING_BETWEEN_SLICES = 0x0018, 0x0088, "SpacingBetweenSlices";
    PROTOCOL_NAME = 0x0018, 0x1030, "ProtocolName";
    TRIGGER_TIME = 0x0018, 0x1060, "TriggerTime";
    CONVOLUTION_KERNEL = 0x0018, 0x1210, "ConvolutionKernel";
    ACQUISITION_MATRIX = 0x0018, 0x1310, "AcquisitionMatrix";
    FLIP_ANGLE = 0x0018, 0x1314, "FlipAngle";
    PATIENT_POSITION = 0x0018, 0x5100, "PatientPosition";
    FRAME_TIME = 0x0018, 0x1063, "FrameTime";
    FRAME_TIME_VECTOR = 0x0018, 0x1065, "FrameTimeVector";
    FRAME_ACQUISITION_DATE_TIME = 0x0018, 0x9074, "FrameAcquisitionDateTime";
    EFFECTIVE_ECHO_TIME = 0x0018, 0x9082, "EffectiveEchoTime";
    DIFFUSION_GRADIENT_DIRECTION_SEQUENCE = 0x0018, 0x9076, "DiffusionGradientDirectionSequence";
    DIFFUSION_B_VALUE = 0x0018, 0x9087, "DiffusionBValue";
    DIFFUSION_GRADIENT_ORIENTATION = 0x0018, 0x9089, "DiffusionGradientOrientation";
    MR_ECHO_SEQUENCE = 0x0018, 0x9114, "MREchoSequence";
    MR_DIFFUSION_SEQUENCE = 0x0018, 0x9117, "MRDiffusionSequence";
    CARDIAC_SYNCHRONIZATION_SEQUENCE = 0x0018, 0x9118, "CardiacSynchronizationSequence";
    MR_IMAGE_FRAME_TYPE_SEQUENCE = 0x0018, 0x9226, "MRImageFrameTypeSequence";
    CT_IMAGE_FRAME_TYPE_SEQUENCE = 0x0018, 0x9329, "CTImageFrameTypeSequence";
    NUMBER_OF_IMAGES_IN_MOSAIC = 0x0019, 0x100A, "NumberOfImagesInMosaic";
    SERIES_INSTANCE_UID = 0x0020, 0x000E, "SeriesInstanceUID";
    SERIES_NUMBER = 0x0020, 0x0011, "SeriesNumber";
    ACQUISITION_NUMBER = 0x0020, 0x0012, "AcquisitionNumber";
    INSTANCE_NUMBER = 0x0020, 0x0013, "InstanceNumber";
    IMAGE_POSITION_PATIENT = 0x0020, 0x0032, "ImagePositionPatient";
    IMAGE_ORIENTATION_PATIENT = 0x0020, 0x0037, "ImageOrientationPatient";
    TEMPORAL_POSITION_IDENTIFIER = 0x0020, 0x0100, "TemporalPositionIdentifier";
    STACK_ID = 0x0020, 0x9056, "StackID";
    IN_STACK_POSITION_NUMBER = 0x0020, 0x9057, "InStackPositionNumber";
    FRAME_CONTENT_SEQUENCE = 0x0020, 0x9111, "FrameContentSequence";
    PLANE_POSITION_SEQUENCE = 0x0020, 0x9113, "PlanePositionSequence";
    PLANE_ORIENTATION_SEQUENCE = 0x0020, 0x9116, "PlaneOrientationSequence";
    TEMPORAL_POSITION_INDEX = 0x0020, 0x9128, "TemporalPositionIndex";
    DIMENSION_INDEX_VALUES = 0x0020, 0x9157, "DimensionIndexValues";
    DIMENSION_INDEX_POINTER = 0x0020, 0x9165, "DimensionIndexPointer";
    DIMENSION_INDEX_SEQUENCE = 0x0020, 0x9222, "DimensionIndexSequence";
    NOMINAL_CARDIAC_TRIGGER_DELAY_TIME = 0x0020, 0x9153, "NominalCardiacTriggerDelayTime";
    SAMPLES_PER_PIXEL = 0x0028, 0x0002, "SamplesPerPixel";
    PLANAR_CONFIGURATION = 0x0028, 0x0006, "PlanarConfiguration";
    PHOTOMETRIC_INTERPRETATION = 0x0028, 0x0004, "PhotometricInterpretation";
    NUMBER_OF_FRAMES = 0x0028, 0x0008, "NumberOfFrames";
    FRAME_INCREMENT_POINTER = 0x0028, 0x0009, "FrameIncrementPointer";
    ROWS = 0x0028, 0x0010, "Rows";
    COLUMNS = 0x0028, 0x0011, "Columns";
    PIXEL_SPACING = 0x0028, 0x0030, "PixelSpacing";
    BITS_ALLOCATED = 0x0028, 0x0100, "BitsAllocated";
    BITS_STORED = 0x0028, 0x0101, "BitsStored";
    HIGH_BIT = 0x0028, 0x0102, "HighBit";
    PIXEL_REPRESENTATION = 0x0028, 0x0103, "PixelRepresentation";
    PIXEL_PADDING_VALUE = 0x0028, 0x0120, "PixelPaddingValue";
    RED_PALETTE_DESCRIPTOR = 0x0028, 0x1101, "RedPaletteColorLookupTableDescriptor";
    GREEN_PALETTE_DESCRIPTOR = 0x0028, 0x1102, "GreenPaletteColorLookupTableDescriptor";
    BLUE_PALETTE_DESCRIPTOR = 0x0028, 0x1103, "BluePaletteColorLookupTableDescriptor";
    RED_PALETTE_DATA = 0x0028, 0x1201, "RedPaletteColorLookupTableData";
    GREEN_PALETTE_DATA = 0x0028, 0x1202, "GreenPaletteColorLookupTableData";
    BLUE_PALETTE_DATA = 0x0028, 0x1203, "BluePaletteColorLookupTableData";
    SEGMENTED_RED_PALETTE_DATA = 0x0028, 0x1221, "SegmentedRedPaletteColorLookupTableData";
    SEGMENTED_GREEN_PALETTE_DATA = 0x0028, 0x1222, "SegmentedGreenPaletteColorLookupTableData";
    SEGMENTED_BLUE_PALETTE_DATA = 0x0028, 0x1223, "SegmentedBluePaletteColorLookupTableData";
    WINDOW_CENTER = 0x0028, 0x1050, "WindowCenter";
    WINDOW_WIDTH = 0x0028, 0x1051, "WindowWidth";
    RESCALE_INTERCEPT = 0x0028, 0x1052, "RescaleIntercept";
    RESCALE_SLOPE = 0x0028, 0x1053, "RescaleSlope";
    RESCALE_TYPE = 0x0028, 0x1054, "RescaleType";
    MODALITY_LUT_SEQUENCE = 0x0028, 0x3000, "ModalityLUTSequence";
    PIXEL_MEASURES_SEQUENCE = 0x0028, 0x9110, "PixelMeasuresSequence";
    FRAME_VOILUT_SEQUENCE = 0x0028, 0x9132, "FrameVOILUTSequence";
    PIXEL_VALUE_TRANSFORMATION_SEQUENCE = 0x0028, 0x9145, "PixelValueTransformationSequence";
    CSA_IMAGE_HEADER = 0x0029, 0x1010, "CSAImageHeaderInfo";
    CSA_IMAGE_HEADER_IN_BLOCK_11 = 0x0029, 0x1110, "CSAImageHeaderInfo";
    CSA_IMAGE_HEADER_IN_BLOCK_12 = 0x0029, 0x1210, "CSAImageHeaderInfo";
    ENERGY_WINDOW_VECTOR = 0x0054, 0x0010, "EnergyWindowVector";
    DETECTOR_VECTOR = 0x0054, 0x0020, "DetectorVector";
    DETECTOR_INFORMATION_SEQUENCE = 0x0054, 0x0022, "DetectorInformationSequence";
    PHASE_VECTOR = 0x0054, 0x0030, "PhaseVector";
    RR_INTERVAL_VECTOR = 0x0054, 0x0060, "RRIntervalVector";
    TIME_SLOT_VECTOR = 0x0054, 0x0070, "TimeSlotVector";
    SLICE_VECTOR = 0x0054, 0x0080, "SliceVector";
    ANGULAR_VIEW_VECTOR = 0x0054, 0x0090, "AngularViewVector";
    TIME_SLICE_VECTOR = 0x0054, 0x0100, "TimeSliceVector";
    SEGMENTATION_TYPE = 0x0062, 0x0001, "SegmentationType";
    SEGMENT_SEQUENCE = 0x0062, 0x0002, "SegmentSequence";
    SEGMENTED_PROPERTY_CATEGORY_CODE_SEQUENCE = 0x0062, 0x0003, "SegmentedPropertyCategoryCodeSequence";
    SEGMENT_NUMBER = 0x0062, 0x0004, "SegmentNumber";
    SEGMENT_LABEL = 0x0062, 0x0005, "SegmentLabel";
    SEGMENT_IDENTIFICATION_SEQUENCE = 0x0062, 0x000A, "SegmentIdentificationSequence";
    REFERENCED_SEGMENT_NUMBER = 0x0062, 0x000B, "ReferencedSegmentNumber";
    RECOMMENDED_DISPLAY_CIELAB_VALUE = 0x0062, 0x000D, "RecommendedDisplayCIELabValue";
    MAXIMUM_FRACTIONAL_VALUE = 0x0062, 0x000E, "MaximumFractionalValue";
    UNITS = 0x0054, 0x1001, "Units";
    FRAME_REFERENCE_TIME = 0x0054, 0x1300, "FrameReferenceTime";
    DOSE_UNITS = 0x3004, 0x0002, "DoseUnits";
    GRID_FRAME_OFFSET_VECTOR = 0x3004, 0x000C, "GridFrameOffsetVector";
    DOSE_GRID_SCALING = 0x3004, 0x000E, "DoseGridScaling";
    STRUCTURE_SET_LABEL = 0x3006, 0x0002, "StructureSetLabel";
    REFERENCED_FRAME_OF_REFERENCE_SEQUENCE = 0x3006, 0x0010, "ReferencedFrameOfReferenceSequence";
    RT_REFERENCED_STUDY_SEQUENCE = 0x3006, 0x0012, "RTReferencedStudySequence";
    RT_REFERENCED_SERIES_SEQUENCE = 0x3006, 0x0014, "RTReferencedSeriesSequence";
    STRUCTURE_SET_ROI_SEQUENCE = 0x3006, 0x0020, "StructureSetROISequence";
    ROI_NUMBER = 0x3006, 0x0022, "ROINumber";
    ROI_NAME = 0x3006, 0x0026, "ROIName";
    ROI_DISPLAY_COLOR = 0x3006, 0x002A, "ROIDisplayColor";
    ROI_CONTOUR_SEQUENCE = 0x3006, 0x0039, "ROIContourSequence";
    CONTOUR_SEQUENCE = 0x3006, 0x0040, "ContourSequence";
    CONTOUR_GEOMETRIC_TYPE = 0x3006, 0x0042, "ContourGeometricType";
    CONTOUR_SLAB_THICKNESS = 0x3006, 0x0044, "ContourSlabThickness";
    CONTOUR_DATA = 0x3006, 0x0050, "ContourData";
    RT_ROI_OBSERVATIONS_SEQUENCE = 0x3006, 0x0080, "RTROIObservationsSequence";
    REFERENCED_ROI_NUMBER = 0x3006, 0x0084, "ReferencedROINumber";
    RT_ROI_INTERPRETED_TYPE = 0x3006, 0x00A4, "RTROIInterpretedType";
    SHARED_FUNCTIONAL_GROUPS_SEQUENCE = 0x5200, 0x9229, "SharedFunctionalGroupsSequence";
    PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE = 0x5200, 0x9230, "PerFrameFunctionalGroupsSequence";
    EXTENDED_OFFSET_TABLE = 0x7FE0, 0x0001, "ExtendedOffsetTable";
    FLOAT_PIXEL_DATA = 0x7FE0, 0x0008, "FloatPixelData";
    DOUBLE_FLOAT_PIXEL_DATA = 0x7FE0, 0x0009, "DoubleFloatPixelData";
    PIXEL_DATA = 0x7FE0, 0x0010, "PixelData";
}
