"""Reports: reads the folder of a run and draws it. Knows files only, no process and no ROS."""
