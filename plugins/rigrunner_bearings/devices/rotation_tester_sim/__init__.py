"""A bench that turns a bearing slowly from rest: breakaway torque, without load or under one."""
