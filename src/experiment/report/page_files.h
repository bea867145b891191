/* The script and the style of a report, which the build makes of the files in page/. */
#pragma once

extern const char ll_report_script[], ll_report_style[];
