# SPDX-License-Identifier: MIT
# tgzmotion: flat image for the Cortex-A9 of TGZ+Motion. Built as for TGMcontroller; the vendor's stamper makes
# a .tgz_motion file of the .tgm.bin.
include $(TGM_SDK)/mk/target-tgmcontroller.mk
