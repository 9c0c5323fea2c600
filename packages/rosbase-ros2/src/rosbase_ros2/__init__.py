"""rosbase on ROS 2: the backend `ros2`, on rclpy."""
