# ITK, the Insight Toolkit. Apache-2.0.
# Reads and writes scans (NRRD, MetaImage, NIfTI, DICOM through GDCM, BSD-3-Clause).
find_package(ITK 5.2 REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIONRRD ITKIOMeta ITKIONIFTI
             ITKIOGDCM)
