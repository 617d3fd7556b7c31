// The page of `clearway calibrate --live`: the dashboard's panel alone, which only looks.

import { Calibration } from "./calibration.js";

new Calibration({ authorization: {} }, null);
